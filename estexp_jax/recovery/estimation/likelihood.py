"""How well hypotheses reproduce recordings of a robot that its simulator describes only roughly.

Each hypothesis is replayed: its network hears the recorded readings, so that small errors do not feed on themselves.
What is left between recorded and simulated readings is compared with what errors of a few percent in the simulator's
parameters do to them about a reference hypothesis: see `mismatch`. The healthy robot's trials stand in both as well: an
error that the robot has shown before the damage is not taken for damage. All is simulated at half the physics step: no
robot has one, and where feet stick and slip, it does more to the angles than errors of gains, damping or friction do.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, final

import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.estimation.base import changes_of
from estexp_jax.recovery.estimation.error_model import (
    SAMPLES,
    Reference,
    angle_cost,
    angle_deviations,
    linearise_errors_at,
    touch_cost,
)
from estexp_jax.recovery.estimation.genome import Items
from estexp_jax.recovery.model_error import perturbed_robots
from estexp_jax.recovery.simulator import DamageSimulator

_MEMBERS, _MANY = 48, 256
"""Of an ensemble; and of one that also meets the rare robots in which a leg slips or the torso tips over."""
_GENEROUS = 0.6
"""Cost of a sample of the truth: V and X are so much too large, and the log determinant beside costs in their unit."""


@final
@dataclass(frozen=True, eq=False)
class Measurements:
    """Trials with the controllers that drove them.

    Attributes:
        weights: (trials, n_weights).
        readings: (trials, samples, n_inputs) raw.
        heard: (trials, samples, n_inputs) what the networks heard.
    """

    weights: np.ndarray
    readings: np.ndarray
    heard: np.ndarray


@final
class EnsembleLikelihood:
    """See the module.

    Args:
        simulator: of the robot; its catalogue holds what `perturbation.ensemble` changes.
        settings: of the run.
        controllers: (n_weights,) each, as many as trials.
        trials: of the damaged robot.
        healthy: controllers and trials of the robot before the damage; may be empty.
        members: of the ensemble of simulators.
    """

    def __init__(
        self,
        simulator: DamageSimulator,
        settings: Settings,
        controllers: Sequence[np.ndarray],
        trials: Sequence[Trial],
        healthy: Sequence[tuple[np.ndarray, Trial]],
        members: int = _MEMBERS,
    ) -> None:
        self._simulator, self._touch = simulator.finer, simulator.walker.interface.is_touch
        self._with_members = partial(EnsembleLikelihood, simulator, settings, controllers, trials, healthy)
        self._members = perturbed_robots(simulator.robot, settings.rough, members)
        self._damaged = _recorded(controllers, trials)
        self._healthy = _recorded([w for w, _ in healthy], [t for _, t in healthy]) if healthy else None
        self._before = self._about_healthy()
        self._references: dict[Items, Reference] = {}

    def __call__(self, hypotheses: Sequence[Items], reference: Items = ()) -> np.ndarray:
        """Costs, (n,); not finite where a simulation blew up."""
        about = self._reference(reference)
        simulated, failed = self._replayed(hypotheses)
        angles = (self._damaged.readings - simulated)[..., ~self._touch].reshape(len(hypotheses), -1)
        known = np.broadcast_to(self._before[0], (len(hypotheses), self._before[0].size))
        cost = angle_cost(about, np.concatenate([known, angles], axis=1))
        cost = cost + touch_cost(about, self._damaged.readings[..., self._touch], simulated[..., self._touch])
        return np.where(failed, np.inf, cost)

    def alone(self, hypothesis: Items, *, thorough: bool = False) -> tuple[float, float]:
        """See `HypothesisCost`: cost and log determinant, comparable between hypotheses; and the cost of a sample."""
        if thorough:
            return self._larger.alone(hypothesis)
        cost, about = float(self([hypothesis], hypothesis)[0]), self._references.pop(hypothesis)
        return cost + _GENEROUS * about.log_det, cost / len(about.sd)

    @cached_property
    def _larger(self) -> EnsembleLikelihood:
        return self._with_members(members=_MANY)

    def _reference(self, items: Items) -> Reference:
        if items not in self._references:
            self._references[items] = self._about(items)
        return self._references[items]

    def _about(self, items: Items) -> Reference:
        centre = changes_of(self._simulator, items)
        walk = self._walk([centre, *((*centre, *member) for member in self._members)], self._damaged)
        return linearise_errors_at(walk, self._touch, self._before[1])

    def _about_healthy(self) -> tuple[np.ndarray, np.ndarray]:
        """Errors (samples,) and deviations (members, samples) of the trials before the damage."""
        if self._healthy is None:
            return np.zeros(0), np.zeros((len(self._members), 0))
        walk = self._walk([(), *self._members], self._healthy)
        errors = (self._healthy.readings - walk[0])[..., ~self._touch].ravel()
        return errors, angle_deviations(walk, self._touch, np.zeros((len(self._members), 0)))

    def _replayed(self, hypotheses: Sequence[Items]) -> tuple[np.ndarray, Any]:
        sets = [changes_of(self._simulator, items) for items in hypotheses]
        seen = self._damaged
        walk = self._simulator.trials(sets, seen.weights, seen.heard.shape[1], seen.heard)
        failed = np.any(np.asarray(walk.failed), axis=1)
        return np.where(failed[:, None, None, None], 0.0, np.asarray(walk.readings, float)), failed

    def _walk(self, sets: Sequence[Sequence], seen: Measurements) -> np.ndarray:
        walk = self._simulator.trials(sets, seen.weights, seen.heard.shape[1], seen.heard)
        return np.asarray(walk.readings, float)


def _recorded(controllers: Sequence[np.ndarray], trials: Sequence[Trial]) -> Measurements:
    n = min(SAMPLES, *(len(trial.readings) for trial in trials))
    tables = ([trial.readings[:n] for trial in trials], [trial.network_heard[:n] for trial in trials])
    return Measurements(np.stack(list(controllers)), *(np.stack(table) for table in tables))
