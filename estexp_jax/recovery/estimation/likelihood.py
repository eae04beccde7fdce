"""Likelihood of hypotheses when the simulator has errors, from an ensemble of perturbed simulators.

Each hypothesis is simulated with the recorded readings as the network's inputs, so that small errors do not grow in the
loop. Residuals are weighted by the deviations that parameter errors of a few percent cause about a reference
hypothesis: see `error_model`. The healthy robot's trials are included in both, so that an error present before the
damage is not taken for damage. All is simulated at half the physics step: with feet that stick and slip, the
integration error is larger than that of gains, damping or friction.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, final

import numpy as np

from estexp_jax.physics.engines.closed_loop import Rollout
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.estimation.damage_sites import changes_of
from estexp_jax.recovery.estimation.error_model import (
    SAMPLES,
    ErrorModel,
    angle_cost,
    angle_deviations,
    linearise_errors_at,
    touch_cost,
)
from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.recovery.model_error import perturbed_robots
from estexp_jax.recovery.simulator import DamageSimulator

_MEMBERS, _MANY = 48, 256
"""Size of an ensemble; and of one that also contains rare events, such as a slipping leg or a fall."""
_LOG_DET_WEIGHT = 0.6
"""Cost of a sample under the true hypothesis, as V and X are too large; the log determinant is scaled alike."""


@final
@dataclass(frozen=True, eq=False)
class Measurements:
    """Trials with the controllers that drove them.

    Attributes:
        weights: (trials, n_weights).
        readings: (trials, samples, n_inputs) raw.
        network_readings: (trials, samples, n_inputs) raw readings that the networks received.
    """

    weights: np.ndarray
    readings: np.ndarray
    network_readings: np.ndarray


@final
class EnsembleLikelihood:
    """A `HypothesisCost`: see the module.

    Args:
        simulator: of the robot; its catalogue holds the effects of `perturbed_robots`.
        settings: of the run.
        controllers: (n_weights,) each, one for each trial.
        trials: of the damaged robot.
        healthy: controllers and trials of the robot before the damage; may be empty.
        ensemble_size: number of perturbed simulators.
    """

    def __init__(
        self,
        simulator: DamageSimulator,
        settings: Settings,
        controllers: Sequence[np.ndarray],
        trials: Sequence[Trial],
        healthy: Sequence[tuple[np.ndarray, Trial]],
        ensemble_size: int = _MEMBERS,
    ) -> None:
        self._simulator, self._touch = simulator.finer, simulator.closed_loop.interface.is_touch
        self._with_members = partial(EnsembleLikelihood, simulator, settings, controllers, trials, healthy)
        self._members = perturbed_robots(simulator.robot, settings.relative_error, ensemble_size)
        self._damaged = _measurements(controllers, trials)
        self._healthy = _measurements([w for w, _ in healthy], [t for _, t in healthy]) if healthy else None
        self._before = self._healthy_errors()
        self._references: dict[DamageHypothesis, ErrorModel] = {}

    def __call__(self, hypotheses: Sequence[DamageHypothesis], reference: DamageHypothesis = ()) -> np.ndarray:
        """Costs (n,) of hypotheses; not finite where a simulation diverged."""
        model = self._reference(reference)
        simulated, failed = self._replay(hypotheses)
        angles = (self._damaged.readings - simulated)[..., ~self._touch].reshape(len(hypotheses), -1)
        known = np.broadcast_to(self._before[0], (len(hypotheses), self._before[0].size))
        cost = angle_cost(model, np.concatenate([known, angles], axis=1))
        cost = cost + touch_cost(model, self._damaged.readings[..., self._touch], simulated[..., self._touch])
        return np.where(failed, np.inf, cost)

    def evaluate(self, hypothesis: DamageHypothesis, *, thorough: bool = False) -> tuple[float, float]:
        """See `HypothesisCost`: cost and log determinant, comparable between hypotheses; and the cost of a sample."""
        if thorough:
            return self._larger.evaluate(hypothesis)
        cost, model = float(self([hypothesis], hypothesis)[0]), self._references.pop(hypothesis)
        return cost + _LOG_DET_WEIGHT * model.log_det, cost / len(model.sd)

    @cached_property
    def _larger(self) -> EnsembleLikelihood:
        return self._with_members(ensemble_size=_MANY)

    def _reference(self, items: DamageHypothesis) -> ErrorModel:
        if items not in self._references:
            self._references[items] = self._linearised_at(items)
        return self._references[items]

    def _linearised_at(self, items: DamageHypothesis) -> ErrorModel:
        centre = changes_of(self._simulator, items)
        readings = self._readings([centre, *((*centre, *member) for member in self._members)], self._damaged)
        return linearise_errors_at(readings, self._touch, self._before[1])

    def _healthy_errors(self) -> tuple[np.ndarray, np.ndarray]:
        """Residuals (samples,) and deviations (members, samples) in the trials before the damage."""
        if self._healthy is None:
            return np.zeros(0), np.zeros((len(self._members), 0))
        readings = self._readings([(), *self._members], self._healthy)
        errors = (self._healthy.readings - readings[0])[..., ~self._touch].ravel()
        return errors, angle_deviations(readings, self._touch, np.zeros((len(self._members), 0)))

    def _replay(self, hypotheses: Sequence[DamageHypothesis]) -> tuple[np.ndarray, Any]:
        sets = [changes_of(self._simulator, items) for items in hypotheses]
        rollout = self._rollout(sets, self._damaged)
        failed = np.any(np.asarray(rollout.failed), axis=1)
        return np.where(failed[:, None, None, None], 0.0, np.asarray(rollout.readings, float)), failed

    def _readings(self, sets: Sequence[Sequence], measured: Measurements) -> np.ndarray:
        return np.asarray(self._rollout(sets, measured).readings, float)

    def _rollout(self, sets: Sequence[Sequence], measured: Measurements) -> Rollout:
        """Simulate robots with these changes under the measured trials' controllers and readings."""
        inputs = measured.network_readings
        return self._simulator.trials(sets, measured.weights, inputs.shape[1], inputs)


def _measurements(controllers: Sequence[np.ndarray], trials: Sequence[Trial]) -> Measurements:
    n = min(SAMPLES, *(len(trial.readings) for trial in trials))
    tables = ([trial.readings[:n] for trial in trials], [trial.network_readings[:n] for trial in trials])
    return Measurements(np.stack(list(controllers)), *(np.stack(table) for table in tables))
