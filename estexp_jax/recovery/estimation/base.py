"""The estimation phase: find the changes that make the simulator reproduce the recorded trials.

Three ways: the paper's genetic algorithm over its genome; a set search, for a robot that its simulator describes
exactly; and a set search under replay, for one that it describes roughly. All are chains of rounds whose states are
plain data.

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
from estexp_jax.recovery.estimation.edits import Place, change_of
from estexp_jax.recovery.estimation.genome import Items
from estexp_jax.recovery.estimation.metrics import distance_error, rolling_mean
from estexp_jax.recovery.simulator import DamageSimulator


class HypothesisCost(Protocol):
    """How badly hypotheses reproduce what was recorded."""

    def __call__(self, hypotheses: Sequence[Items], reference: Items = ()) -> np.ndarray:
        """Of each hypothesis, (n,); not finite where a simulation blew up.

        Args:
            hypotheses: what may differ.
            reference: where the simulator's own errors are judged, for those residuals that know of any.
        """
        ...

    def alone(self, hypothesis: Items, *, thorough: bool = False) -> tuple[float, float]:
        """Of one hypothesis, the simulator's errors judged about itself; and how badly it fits, 1 being as expected.

        Args:
            hypothesis: what may differ.
            thorough: whether these errors are judged by more of them; not to be compared with others that are not.
        """
        ...


class DamageDiagnosis(NamedTuple):
    """What the estimation believes.

    Attributes:
        items: what differs.
        residual: how badly it reproduces what was recorded.
        probability: None where the method gives none.
        rivals: other explanations that it could not exclude, with their probabilities, likeliest first.
        alarm: whether nothing in the catalogue reproduces the recordings; None where the method does not tell.
    """

    items: Items
    residual: float
    probability: float | None
    rivals: tuple[tuple[Items, float], ...] = ()
    alarm: bool | None = None


class Round(NamedTuple):
    """What a round of an estimation has to tell."""

    best: float  #: lowest residual, or for the set search that of the best hypothesis
    median: float  #: over the population, or over the hypotheses kept
    dominants: int  #: new hypotheses better than all of the round before


class Estimation(abc.ABC):
    """A way to find a diagnosis, round by round; states are trees that a checkpoint can hold."""

    @abc.abstractmethod
    def begin(self, seeds: Sequence[Any]) -> dict[str, Any]:
        """The state before the first round; `seeds` are what `seed` gave after earlier passes."""

    @abc.abstractmethod
    def advance(self, state: dict[str, Any], residuals: HypothesisCost) -> dict[str, Any]:
        """The state after one more round."""

    @abc.abstractmethod
    def done(self, state: dict[str, Any]) -> bool:
        """Whether all rounds are through."""

    @abc.abstractmethod
    def rounds(self) -> int | None:
        """How many there will be; None where nobody knows."""

    @abc.abstractmethod
    def diagnosis(self, state: dict[str, Any]) -> DamageDiagnosis:
        """The best hypothesis so far."""

    @abc.abstractmethod
    def seed(self, state: dict[str, Any]) -> Any:
        """What a later pass begins with, as a tree."""

    @abc.abstractmethod
    def summary(self, state: dict[str, Any]) -> Round:
        """Numbers of the last round."""


def changes_of(simulator: DamageSimulator, items: Sequence[tuple[Place, float]]) -> tuple[Any, ...]:
    """The changes that a diagnosis stands for."""
    return tuple(change_of(simulator.robot, place, amount) for place, amount in items)


class MetricCost:
    """The paper's metrics on all trials so far: in closed loop for the paper's search, else under replay.

    Replay takes apart what the loop ties together: a faulty sensor then shows in its own reading only, and not in all
    that its controller does with it.

    Args:
        simulator: of the robot.
        settings: of the run; its metric decides how long hypotheses are simulated.
        controllers: (n_weights,) each, as many as trials.
        trials: what the robot in the world did under them.
    """

    def __init__(
        self, simulator: DamageSimulator, settings: Settings, controllers: Sequence[np.ndarray], trials: Sequence[Trial]
    ) -> None:
        self._simulator, self._settings = simulator, settings
        self._weights = np.stack(list(controllers))
        self._short = settings.metric == "rolling-mean"
        self._inputs = self._seen(np.stack([t.readings[: settings.samples] for t in trials]))
        replayed = self._short and not settings.paper
        # In closed loop no network would give commands that were played open loop.
        open_loop = any(t.heard is not None for t in trials)
        self._heard = np.stack([t.network_heard for t in trials]) if replayed or open_loop else None
        self._travelled = np.array([t.distance(settings.axis) for t in trials])

    def __call__(self, hypotheses: Sequence[Items], reference: Items = ()) -> np.ndarray:
        """See `HypothesisCost`."""
        settings = self._settings
        sets = [changes_of(self._simulator, items) for items in hypotheses]
        steps = settings.samples if self._short else settings.steps
        walk = self._simulator.trials(sets, self._weights, steps, self._heard)
        if self._short:
            seen = self._seen(walk.readings)
            values = rolling_mean(self._inputs, seen, header=settings.header, window=settings.window)
        else:
            values = distance_error(self._travelled, distances_along(walk.position, settings.axis))
        return np.where(walk.failed.any(axis=1), np.inf, values)

    def alone(self, hypothesis: Items, *, thorough: bool = False) -> tuple[float, float]:
        """See `HypothesisCost`; a simulator without errors reproduces the truth exactly."""
        value = float(self([hypothesis])[0])
        return value, value / _NOTHING

    def _seen(self, readings: np.ndarray) -> np.ndarray:
        return np.asarray(self._simulator.walker.interface.inputs(jnp.asarray(readings)))


_NOTHING = 0.0005
"""Residual that counts as none."""
