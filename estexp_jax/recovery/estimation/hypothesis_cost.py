"""How far hypotheses of damage are from the recorded trials.

Costs are of two kinds: the paper's metrics (`metrics`), here; and, for simulators with errors, a likelihood from an
ensemble of perturbed simulators (`likelihood`). `choice` takes one of them for a run.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import jax.numpy as jnp
import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import Trial, distances_along
from estexp_jax.recovery.estimation.damage_sites import changes_of
from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.recovery.estimation.metrics import distance_error, rolling_mean
from estexp_jax.recovery.simulator import DamageSimulator


class HypothesisCost(Protocol):
    """Cost of hypotheses: how far their simulations are from the recordings."""

    def __call__(self, hypotheses: Sequence[DamageHypothesis], reference: DamageHypothesis = ()) -> np.ndarray:
        """Costs (n,) of hypotheses; not finite where a simulation diverged.

        Args:
            hypotheses: the damage.
            reference: hypothesis about which the simulator's errors are linearised, by costs that model such errors.
        """
        ...

    def evaluate(self, hypothesis: DamageHypothesis, *, thorough: bool = False) -> tuple[float, float]:
        """Cost of one hypothesis with errors linearised about itself, and its misfit: 1 is as expected.

        Args:
            hypothesis: the damage.
            thorough: whether a larger ensemble of simulators is used; costs of the two ensembles are not comparable.
        """
        ...


class MetricCost:
    """The paper's metrics on all trials so far, in closed loop for the paper's search, else with replayed readings.

    With recorded readings as the networks' inputs, a faulty sensor changes its own reading only. In closed loop it
    changes the whole motion.

    Args:
        simulator: of the robot.
        settings: of the run; the metric determines how many steps are simulated.
        controllers: (n_weights,) each, one for each trial.
        trials: of the robot in the world.
    """

    def __init__(
        self, simulator: DamageSimulator, settings: Settings, controllers: Sequence[np.ndarray], trials: Sequence[Trial]
    ) -> None:
        self._simulator, self._settings = simulator, settings
        self._weights = np.stack(list(controllers))
        self._short = settings.metric == "rolling-mean"
        self._inputs = self._inputs_of(np.stack([t.readings[: settings.samples] for t in trials]))
        replayed = self._short and not settings.paper
        # Commands that were played open loop are no network's output in closed loop: their readings are replayed.
        open_loop = any(t.open_loop_readings is not None for t in trials)
        self._network_readings = np.stack([t.network_readings for t in trials]) if replayed or open_loop else None
        self._travelled = np.array([t.distance(settings.axis) for t in trials])

    def __call__(self, hypotheses: Sequence[DamageHypothesis], reference: DamageHypothesis = ()) -> np.ndarray:
        """See `HypothesisCost`."""
        settings = self._settings
        sets = [changes_of(self._simulator, items) for items in hypotheses]
        steps = settings.samples if self._short else settings.steps
        rollout = self._simulator.trials(sets, self._weights, steps, self._network_readings)
        if self._short:
            inputs = self._inputs_of(rollout.readings)
            values = rolling_mean(self._inputs, inputs, header=settings.header, window=settings.window)
        else:
            values = distance_error(self._travelled, distances_along(rollout.position, settings.axis))
        return np.where(rollout.failed.any(axis=1), np.inf, values)

    def evaluate(self, hypothesis: DamageHypothesis, *, thorough: bool = False) -> tuple[float, float]:
        """See `HypothesisCost`; an exact simulator has no errors to linearise."""
        value = float(self([hypothesis])[0])
        return value, value / _NO_ERROR

    def _inputs_of(self, readings: np.ndarray) -> np.ndarray:
        return np.asarray(self._simulator.closed_loop.interface.inputs(jnp.asarray(readings)))


_NO_ERROR = 0.0005
"""Residual that counts as none; the unit of the misfit."""
