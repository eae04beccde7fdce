"""The genetic algorithm of Bongard and Lipson, for both of their phases, with an ask/tell interface.

Half of the population survives a generation. The other half is replaced by tournament winners among the survivors,
copied and mutated, some pairs of which then cross over. The simulation is deterministic, so survivors keep their scores
and only new genomes are asked for.

Each generation has its own random generator, seeded by (seed, tags, generation). So no random state is stored, and a
search that is resumed from a file gives the same results bit for bit.

Source: Bongard and Lipson 2004, section 2.2, "The Exploration Phase".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, final

import numpy as np

RESOLUTION = 100
"""Values are multiples of 1 / RESOLUTION in [-1, 1]: the paper's two decimal places."""


@final
@dataclass(frozen=True)
class Genetic:
    """The algorithm's settings.

    Attributes:
        length: values in a genome.
        population: genomes in a generation, at least 4.
        seed: of the random numbers, together with `tags`.
        tags: distinguish searches with the same seed, such as by phase and pass.
        mutation: probability that a value of a copied genome is drawn anew.
        tournament: survivors drawn for each tournament.
        crossover: pairs that cross over, as a share of the copied genomes: 24 of 100.

    Raises:
        ValueError: a setting is out of range.
    """

    length: int
    population: int = 200
    seed: int = 0
    tags: tuple[int, ...] = ()
    mutation: float = 0.01
    tournament: int = 3
    crossover: float = 0.24

    def __post_init__(self) -> None:
        if self.population < 4 or self.length < 2:
            raise ValueError(f"{self.population} genomes of {self.length} values: at least 4 of 2 are needed")
        if not 0.0 <= self.mutation <= 1.0 or not 0.0 <= self.crossover <= 0.5 or self.tournament < 1:
            raise ValueError("mutation must lie in 0..1, crossover in 0..0.5, and a tournament needs a genome")

    @property
    def survivors(self) -> int:
        """Number of genomes that survive: the better half."""
        return self.population // 2


class Population(NamedTuple):
    """A generation, best first; empty before the first."""

    genomes: np.ndarray  #: (n, length)
    scores: np.ndarray  #: (n,) lower is better; +inf where the simulation diverged
    generation: int  #: generations completed
    dominants: int  #: new genomes of the last generation strictly better than all of the one before

    def to_tree(self) -> dict[str, Any]:
        """The tree of plain data that a checkpoint holds."""
        return self._asdict()

    @classmethod
    def from_tree(cls, tree: dict[str, Any]) -> Population:
        """The inverse of `to_tree`."""
        return cls(**tree)


def begin_genetic(genetic: Genetic) -> Population:
    """The state before the first generation."""
    return Population(np.zeros((0, genetic.length)), np.zeros(0), 0, 0)


def ask_genetic(genetic: Genetic, state: Population, seeds: Sequence[np.ndarray] = ()) -> np.ndarray:
    """The genomes to simulate next.

    Args:
        genetic: the settings.
        state: the generation before.
        seeds: (length,) each; they replace the first genomes of the first generation.

    Returns:
        (population, length) for the first generation, then (population - survivors, length).
    """
    random = np.random.default_rng([genetic.seed, *genetic.tags, state.generation])
    if state.generation > 0:
        return _children(genetic, state.genomes[: genetic.survivors], random)
    genomes = _values(random, (genetic.population, genetic.length))
    for place, seed in enumerate(list(seeds)[: genetic.population]):
        genomes[place] = seed
    return genomes


def tell_genetic(genetic: Genetic, state: Population, genomes: np.ndarray, scores: np.ndarray) -> Population:
    """The next generation.

    Args:
        genetic: the settings.
        state: the generation before.
        genomes: as returned by `ask_genetic`.
        scores: (len(genomes),) lower is better; values that are not finite count as +inf.
    """
    scores = np.where(np.isfinite(scores), scores, np.inf)
    dominants = int(np.sum(scores < state.scores[0])) if state.generation else 0
    genomes = np.concatenate([state.genomes[: genetic.survivors], genomes])
    scores = np.concatenate([state.scores[: genetic.survivors], scores])
    order = np.argsort(scores, kind="stable")
    return Population(genomes[order], scores[order], state.generation + 1, dominants)


def _children(genetic: Genetic, parents: np.ndarray, random: np.random.Generator) -> np.ndarray:
    n = genetic.population - genetic.survivors
    # The parents are sorted, so the winner of a tournament is the one with the lowest index.
    children = parents[random.integers(len(parents), size=(n, genetic.tournament)).min(axis=1)]
    mutated = random.random(children.shape) < genetic.mutation
    children = np.where(mutated, _values(random, children.shape), children)
    pairs = round(genetic.crossover * n)
    chosen = random.permutation(n)[: 2 * pairs].reshape(pairs, 2)
    for (a, b), point in zip(chosen, random.integers(1, genetic.length, size=pairs), strict=True):
        children[a, point:], children[b, point:] = children[b, point:].copy(), children[a, point:].copy()
    return children


def _values(random: np.random.Generator, shape: tuple[int, ...]) -> np.ndarray:
    return random.integers(-RESOLUTION, RESOLUTION + 1, size=shape) / RESOLUTION
