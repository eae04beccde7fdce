"""The estimation phase: find the changes that make the simulator reproduce the recorded trials.

Two ways: the paper's genetic algorithm over its genome, and a set search over the same modifications. Both are chains
of rounds whose states are plain data, and both judge a hypothesis by the same metric on all trials so far.

Source: Bongard and Lipson 2004, section 2.2, "The Estimation Phase".
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple, final

import jax.numpy as jnp
import numpy as np

from estexp_jax.inference import set_moves, set_search
from estexp_jax.inference.set_moves import Option
from estexp_jax.inference.set_search import SetSearch
from estexp_jax.physics.registry import PAPER
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.edits import Place, change_of, merged, places
from estexp_jax.recovery.genome import LENGTH, Codec, Items, key
from estexp_jax.recovery.metrics import distance_error, rolling_mean
from estexp_jax.recovery.simulator import Simulator
from estexp_jax.recovery.trial import Trial, distances
from estexp_jax.search import genetic
from estexp_jax.search.genetic import Genetic, Population

TAG = 2
"""In the random numbers' seed: the estimation phase."""
_WEIGHT = 4.0
"""Of an objective in a probability: as if so many samples were independent. Rough; probabilities are not calibrated."""
_COARSE: dict[str, tuple[float, float, tuple[float, ...]]] = {
    "part_lost": (1.0, 1.0, (1.0,)),
    "body_mass": (-0.9, 1.0, (-0.6, -0.3, 0.4, 0.7, 1.0)),
    "motor_weakness": (0.0, 1.0, (0.2, 0.4, 0.7, 1.0)),
    "sensor_gain": (0.0, 1.0, (0.2, 0.4, 0.7, 1.0)),
    "joint_jam": (0.0, 1.0, (0.2, 0.4, 0.7, 1.0)),
    "gravity_tilt": (-1.0, 1.0, (-1.0, -0.67, -0.33, 0.33, 0.67, 1.0)),
}
"""Amounts of each modification: lowest, highest, and those tried first."""

Residuals = Callable[[Sequence[Items]], np.ndarray]
"""Hypotheses to their residuals; not finite where a simulation blew up."""


class Diagnosis(NamedTuple):
    """What the estimation believes."""

    items: Items
    residual: float
    probability: float | None  #: None where the method gives none


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
    def advance(self, state: dict[str, Any], residuals: Residuals) -> dict[str, Any]:
        """The state after one more round."""

    @abc.abstractmethod
    def done(self, state: dict[str, Any]) -> bool:
        """Whether all rounds are through."""

    @abc.abstractmethod
    def rounds(self) -> int | None:
        """How many there will be; None where nobody knows."""

    @abc.abstractmethod
    def diagnosis(self, state: dict[str, Any]) -> Diagnosis:
        """The best hypothesis so far."""

    @abc.abstractmethod
    def seed(self, state: dict[str, Any]) -> Any:
        """What a later pass begins with, as a tree."""

    @abc.abstractmethod
    def summary(self, state: dict[str, Any]) -> Round:
        """Numbers of the last round."""


@final
class PaperEstimation(Estimation):
    """The paper's genetic algorithm; genomes that say the same are simulated once a pass."""

    def __init__(self, simulator: Simulator, settings: Settings, number: int) -> None:
        self._codec = Codec(simulator.robot)
        self._generations = settings.generations
        self._genetic = Genetic(LENGTH, settings.population, settings.seed, (TAG, number), settings.mutation)

    def begin(self, seeds: Sequence[Any]) -> dict[str, Any]:
        """See `Estimation`."""
        population = genetic.begin(self._genetic).to_tree()
        return {"population": population, "seeds": [np.asarray(s) for s in seeds], "known": {}}

    def advance(self, state: dict[str, Any], residuals: Residuals) -> dict[str, Any]:
        """See `Estimation`."""
        population = Population.from_tree(state["population"])
        genomes = genetic.ask(self._genetic, population, state["seeds"])
        items = [self._codec.items(genome) for genome in genomes]
        new = {key(i): i for i in items if key(i) not in state["known"]}
        values = residuals(list(new.values())) if new else np.zeros(0)
        known = {**state["known"], **{k: float(v) for k, v in zip(new, values, strict=True)}}
        scores = np.array([known[key(i)] for i in items])
        told = genetic.tell(self._genetic, population, genomes, scores)
        return {**state, "population": told.to_tree(), "known": known}

    def done(self, state: dict[str, Any]) -> bool:
        """See `Estimation`."""
        return state["population"]["generation"] >= self._generations

    def rounds(self) -> int | None:
        """See `Estimation`."""
        return self._generations

    def diagnosis(self, state: dict[str, Any]) -> Diagnosis:
        """See `Estimation`."""
        population = Population.from_tree(state["population"])
        return Diagnosis(self._codec.items(population.genomes[0]), float(population.scores[0]), None)

    def seed(self, state: dict[str, Any]) -> Any:
        """See `Estimation`."""
        return state["population"]["genomes"][0]

    def summary(self, state: dict[str, Any]) -> Round:
        """See `Estimation`."""
        population = Population.from_tree(state["population"])
        return Round(float(population.scores[0]), float(np.median(population.scores)), population.dominants)


@final
class SetEstimation(Estimation):
    """The set search: all places first, amounts later, a price on each change."""

    def __init__(self, simulator: Simulator, settings: Settings) -> None:
        robot = simulator.robot
        self._robot = robot
        self._places = tuple(place for name in PAPER for place in places(robot, name))
        self._search = SetSearch(tuple(Option(*_COARSE[p.effect]) for p in self._places))

    def begin(self, seeds: Sequence[Any]) -> dict[str, Any]:
        """See `Estimation`."""
        return {"search": set_search.begin().to_tree(), "seeds": list(seeds), "dominants": 0}

    def advance(self, state: dict[str, Any], residuals: Residuals) -> dict[str, Any]:
        """See `Estimation`."""
        before = set_search.State.from_tree(state["search"])
        seeds = [tuple((int(o), float(a)) for o, a in seed) for seed in state["seeds"]]
        asked = set_search.ask(self._search, before, seeds)
        values = residuals([self._items(items) for items in asked])
        after = set_search.tell(self._search, before, asked, values)
        least = min((f.residual for f in before.pool), default=-np.inf)
        return {**state, "search": after.to_tree(), "dominants": int(np.sum(np.asarray(values) < least))}

    def done(self, state: dict[str, Any]) -> bool:
        """See `Estimation`."""
        return state["search"]["stage"] == "done"

    def rounds(self) -> int | None:
        """See `Estimation`."""
        return None

    def diagnosis(self, state: dict[str, Any]) -> Diagnosis:
        """See `Estimation`."""
        found = set_search.State.from_tree(state["search"])
        share = set_search.probabilities(self._search, found, _WEIGHT)[0]
        return Diagnosis(self._items(found.pool[0].items), found.pool[0].residual, float(share))

    def seed(self, state: dict[str, Any]) -> Any:
        """See `Estimation`."""
        return state["search"]["pool"][0]["items"]

    def summary(self, state: dict[str, Any]) -> Round:
        """See `Estimation`."""
        residuals = [f["residual"] for f in state["search"]["pool"]]
        return Round(residuals[0], float(np.median(residuals)), state["dominants"])

    def _items(self, items: set_moves.Items) -> Items:
        return merged(self._robot, [(self._places[index], amount) for index, amount in items])


def estimation(simulator: Simulator, settings: Settings, number: int) -> Estimation:
    """The estimation of one pass, counted from 1."""
    return PaperEstimation(simulator, settings, number) if settings.paper else SetEstimation(simulator, settings)


def residuals_of(
    simulator: Simulator, settings: Settings, controllers: Sequence[np.ndarray], trials: Sequence[Trial]
) -> Residuals:
    """The metric of hypotheses on all trials so far.

    Args:
        simulator: of the robot.
        settings: of the run; its metric decides how long hypotheses are simulated.
        controllers: (n_weights,) each, as many as trials.
        trials: what the robot in the world did under them.
    """
    weights = np.stack(list(controllers))
    face, short = simulator.walker.interface, settings.metric == "rolling-mean"
    steps = settings.samples if short else settings.steps
    inputs = np.asarray(face.inputs(jnp.stack([jnp.asarray(t.readings[: settings.samples]) for t in trials])))
    travelled = np.array([t.distance(settings.axis) for t in trials])

    def residuals(hypotheses: Sequence[Items]) -> np.ndarray:
        sets = [[change_of(simulator.robot, place, amount) for place, amount in items] for items in hypotheses]
        walk = simulator.trials(sets, weights, steps)
        if short:
            simulated = np.asarray(face.inputs(jnp.asarray(walk.readings)))
            values = rolling_mean(inputs, simulated, header=settings.header, window=settings.window)
        else:
            values = distance_error(travelled, distances(walk.position, settings.axis))
        return np.where(walk.failed.any(axis=1), np.inf, values)

    return residuals


def changes_of(simulator: Simulator, items: Sequence[tuple[Place, float]]) -> tuple[Any, ...]:
    """The changes that a diagnosis stands for."""
    return tuple(change_of(simulator.robot, place, amount) for place, amount in items)
