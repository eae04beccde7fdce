"""What every method of the estimation phase does: find the changes that make the simulator reproduce the trials.

There are three methods: the paper's genetic algorithm; a set search for exact simulators; and a set search with
replayed readings for simulators with errors. All proceed in iterations, and their states are plain data.

Source: Bongard and Lipson 2004, section 2.2, "The Estimation Phase".
"""

from __future__ import annotations

import abc
from collections.abc import Sequence
from typing import Any, NamedTuple

from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.recovery.estimation.hypothesis_cost import HypothesisCost


class DamageDiagnosis(NamedTuple):
    """The result of an estimation.

    Attributes:
        items: the damage.
        residual: its cost or misfit.
        probability: of it, also against that no hypothesis of the catalogue is right; None if the method gives none.
        alternatives: other explanations that are not excluded, with their probabilities, likeliest first.
        alarm: whether no hypothesis of the catalogue reproduces the recordings; None if the method cannot decide.
    """

    items: DamageHypothesis
    residual: float
    probability: float | None
    alternatives: tuple[tuple[DamageHypothesis, float], ...] = ()
    alarm: bool | None = None


def catalogue_probability(error: float, alarm: float, weight: float) -> float:
    """Probability that a hypothesis of the catalogue is right: even odds where the best one's error is at the alarm.

    Args:
        error: of the best hypothesis.
        alarm: error above which none reproduces the recordings.
        weight: of the logarithm of the error: an effective number of independent samples.
    """
    return 1.0 / (1.0 + (error / alarm) ** weight)


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
