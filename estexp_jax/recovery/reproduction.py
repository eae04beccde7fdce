"""How well hypotheses reproduce recordings of a robot that its simulator describes only roughly.

Each hypothesis is replayed: its network hears the recorded readings, so that small errors do not feed on themselves.
What is left between recorded and simulated angles, e, is compared with what errors of a few percent in the simulator's
parameters do to them. An ensemble of perturbed simulators about a reference hypothesis gives deviations X (members x
samples, each divided by the root of the number of members), and

    cost = e' (V + X'X)^-1 e,    V = diag(noise^2 + floor^2 + (share * spread)^2),

by the Woodbury identity with a matrix no larger than the ensemble. The healthy robot's trials stand in e and X as well:
an error that the robot has shown before the damage is not taken for damage. The spread (of X, a sample) stands in V
because contacts make deviations nonlinear where they are large.

Touch readings: a sign that differs costs 2 log((1 - p) / p), p being the chance of a flipped reading or of a contact
that the ensemble itself is unsure of; a level off by d, log(1 + (d / tolerance)^2).

Source: errors of a model as a random vector whose covariance an ensemble gives: Evensen, Data Assimilation (2009),
chapter 4.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, final

import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation import changes_of
from estexp_jax.recovery.genome import Items
from estexp_jax.recovery.perturbation import FLIPS, NOISE, ensemble
from estexp_jax.recovery.simulator import Simulator
from estexp_jax.recovery.trial import Trial

SAMPLES = 41
"""Readings of a trial that are compared: the first 0.4 s."""
_MEMBERS = 48
_FLOOR, _SHARE = 0.006, 1.0
"""Of angles: errors of the integration, rad; share of the spread that is not linear."""
_GENEROUS = 0.6
"""Cost of a sample of the truth: V and X are so much too large, and the log determinant beside costs in their unit."""
_TOLERANCE = 0.02
"""Of a touch reading's level."""


@final
@dataclass(frozen=True, eq=False)
class Recorded:
    """Trials with the controllers that drove them.

    Attributes:
        weights: (trials, n_weights).
        readings: (trials, samples, n_inputs) raw.
    """

    weights: np.ndarray
    readings: np.ndarray


class _Reference(NamedTuple):
    """What the simulator's errors do about one hypothesis."""

    deviations: np.ndarray  #: (members, samples) whitened
    factor: np.ndarray  #: (members, members) Cholesky factor of 1 + X V^-1 X'
    sd: np.ndarray  #: (samples,) root of V
    log_det: float  #: of V + X'X
    unsure: np.ndarray  #: (trials, samples, touches) chance that a touch reading has the other sign


@final
class Reproduction:
    """See the module.

    Args:
        simulator: of the robot; its catalogue holds what `perturbation.ensemble` changes.
        settings: of the run.
        controllers: (n_weights,) each, as many as trials.
        trials: of the damaged robot.
        healthy: controllers and trials of the robot before the damage; may be empty.
    """

    def __init__(
        self,
        simulator: Simulator,
        settings: Settings,
        controllers: Sequence[np.ndarray],
        trials: Sequence[Trial],
        healthy: Sequence[tuple[np.ndarray, Trial]],
    ) -> None:
        self._simulator, self._touch = simulator, simulator.walker.interface.is_touch
        self._members = ensemble(simulator.robot, settings.rough, _MEMBERS)
        self._damaged = _recorded(controllers, trials)
        self._healthy = _recorded([w for w, _ in healthy], [t for _, t in healthy]) if healthy else None
        self._before = self._about_healthy()
        self._references: dict[Items, _Reference] = {}

    def __call__(self, hypotheses: Sequence[Items], reference: Items = ()) -> np.ndarray:
        """Costs, (n,); not finite where a simulation blew up."""
        about = self._reference(reference)
        simulated, failed = self._replayed(hypotheses)
        angles = (self._damaged.readings - simulated)[..., ~self._touch].reshape(len(hypotheses), -1)
        known = np.broadcast_to(self._before[0], (len(hypotheses), self._before[0].size))
        error = np.concatenate([known, angles], axis=1) / about.sd
        explained = np.linalg.solve(about.factor, about.deviations @ error.T)
        cost = np.sum(error**2, axis=1) - np.sum(explained**2, axis=0) + self._touch_cost(simulated, about.unsure)
        return np.where(failed, np.inf, cost)

    def alone(self, hypothesis: Items) -> tuple[float, float]:
        """See `Residuals`: cost and log determinant, comparable between hypotheses; and the cost of a sample."""
        cost, about = float(self([hypothesis], hypothesis)[0]), self._references.pop(hypothesis)
        return cost + _GENEROUS * about.log_det, cost / len(about.sd)

    def _touch_cost(self, simulated: np.ndarray, unsure: np.ndarray) -> np.ndarray:
        seen, told = self._damaged.readings[..., self._touch], simulated[..., self._touch]
        p = np.clip(FLIPS + unsure, FLIPS, 0.5)
        signs = 2.0 * np.sum((np.sign(seen) != np.sign(told)) * np.log((1.0 - p) / p), axis=(1, 2, 3))
        off = (np.abs(seen) - np.abs(told)) / _TOLERANCE
        return signs + np.sum(np.log1p(off**2), axis=(1, 2, 3))

    def _reference(self, items: Items) -> _Reference:
        if items not in self._references:
            self._references[items] = self._about(items)
        return self._references[items]

    def _about(self, items: Items) -> _Reference:
        centre = changes_of(self._simulator, items)
        walk = self._walk([centre, *((*centre, *member) for member in self._members)], self._damaged)
        deviations = self._deviations(walk, self._before[1])
        sd = np.sqrt(NOISE**2 + _FLOOR**2 + _SHARE**2 * np.sum(deviations**2, axis=0))
        white = deviations / sd
        factor = np.linalg.cholesky(np.eye(len(white)) + white @ white.T)
        log_det = 2.0 * (np.sum(np.log(np.diag(factor))) + np.sum(np.log(sd)))
        signs = np.sign(walk[..., self._touch])
        return _Reference(white, factor, sd, float(log_det), np.mean(signs[1:] != signs[0], axis=0))

    def _about_healthy(self) -> tuple[np.ndarray, np.ndarray]:
        """Errors (samples,) and deviations (members, samples) of the trials before the damage."""
        if self._healthy is None:
            return np.zeros(0), np.zeros((len(self._members), 0))
        walk = self._walk([(), *self._members], self._healthy)
        errors = (self._healthy.readings - walk[0])[..., ~self._touch].ravel()
        return errors, self._deviations(walk, np.zeros((len(self._members), 0)))

    def _deviations(self, walk: np.ndarray, others: np.ndarray) -> np.ndarray:
        """Of the first robot's angles, after those of other trials; a robot that blew up tells nothing."""
        found = (walk[1:] - walk[0])[..., ~self._touch].reshape(len(walk) - 1, -1)
        found = np.where(np.all(np.isfinite(found), axis=1, keepdims=True), found, 0.0)
        return np.concatenate([others, found / np.sqrt(len(found))], axis=1)

    def _replayed(self, hypotheses: Sequence[Items]) -> tuple[np.ndarray, Any]:
        sets = [changes_of(self._simulator, items) for items in hypotheses]
        seen = self._damaged
        walk = self._simulator.trials(sets, seen.weights, seen.readings.shape[1], seen.readings)
        failed = np.any(np.asarray(walk.failed), axis=1)
        return np.where(failed[:, None, None, None], 0.0, np.asarray(walk.readings, float)), failed

    def _walk(self, sets: Sequence[Sequence], seen: Recorded) -> np.ndarray:
        walk = self._simulator.trials(sets, seen.weights, seen.readings.shape[1], seen.readings)
        return np.asarray(walk.readings, float)


def _recorded(controllers: Sequence[np.ndarray], trials: Sequence[Trial]) -> Recorded:
    n = min(SAMPLES, *(len(trial.readings) for trial in trials))
    return Recorded(np.stack(list(controllers)), np.stack([trial.readings[:n] for trial in trials]))
