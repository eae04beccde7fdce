"""The estimation phase: find the changes that make the simulator reproduce the recorded trials.

There are three methods: the paper's genetic algorithm; a set search for exact simulators; and a set search with
replayed readings for simulators with errors. All proceed in iterations, and their states are plain data.

Source: Bongard and Lipson 2004, section 2.2, "The Estimation Phase".
"""

from __future__ import annotations

import abc
from collections.abc import Sequence
from typing import Any, NamedTuple, Protocol

import jax.numpy as jnp
import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import Trial, distances_along
from estexp_jax.recovery.estimation.edits import DamageSite, change_of
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


class DamageDiagnosis(NamedTuple):
    """The result of an estimation.

    Attributes:
        items: the damage.
        residual: its cost or misfit.
        probability: of it; None if the method gives none.
        alternatives: other explanations that are not excluded, with their probabilities, likeliest first.
        alarm: whether no hypothesis of the catalogue reproduces the recordings; None if the method cannot decide.
    """

    items: DamageHypothesis
    residual: float
    probability: float | None
    alternatives: tuple[tuple[DamageHypothesis, float], ...] = ()
    alarm: bool | None = None


class IterationSummary(NamedTuple):
    """Statistics of one iteration of an estimation."""

    best: float  #: lowest residual; for the set search that of the best hypothesis
    median: float  #: over the population, or over the hypotheses kept
    dominants: int  #: new hypotheses better than all of the iteration before


class Estimation(abc.ABC):
    """A method that finds a diagnosis iteratively; its states are trees that a checkpoint can hold."""

    @abc.abstractmethod
    def begin(self, seeds: Sequence[Any]) -> dict[str, Any]:
        """The state before the first iteration; `seeds` are the results of `seed` after earlier passes."""

    @abc.abstractmethod
    def advance(self, state: dict[str, Any], residuals: HypothesisCost) -> dict[str, Any]:
        """The state after one more iteration."""

    @abc.abstractmethod
    def done(self, state: dict[str, Any]) -> bool:
        """Whether the estimation has ended."""

    @abc.abstractmethod
    def n_iterations(self) -> int | None:
        """Number of iterations; None if it is not known in advance."""

    @abc.abstractmethod
    def diagnosis(self, state: dict[str, Any]) -> DamageDiagnosis:
        """The best hypothesis so far."""

    @abc.abstractmethod
    def seed(self, state: dict[str, Any]) -> Any:
        """Initial hypothesis for later passes, as a tree."""

    @abc.abstractmethod
    def summary(self, state: dict[str, Any]) -> IterationSummary:
        """Statistics of the last iteration."""


def changes_of(simulator: DamageSimulator, items: Sequence[tuple[DamageSite, float]]) -> tuple[Any, ...]:
    """The changes of the nominal model that a hypothesis stands for."""
    return tuple(change_of(simulator.robot, place, amount) for place, amount in items)


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
