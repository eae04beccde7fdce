"""Running a genetic algorithm: what is simulated, and resuming."""

from collections.abc import Callable

import numpy as np
import pytest

from estexp_jax.search.driver import evolve
from estexp_jax.search.genetic import Genetic, Population

GENETIC = Genetic(length=12, population=40, seed=3, tags=(1, 2))


def sphere(genomes: np.ndarray) -> np.ndarray:
    return np.sum((genomes - 0.37) ** 2, axis=1)


def counting(score: Callable[[np.ndarray], np.ndarray]) -> tuple[list[int], Callable[[np.ndarray], np.ndarray]]:
    counts: list[int] = []

    def counted(genomes: np.ndarray) -> np.ndarray:
        counts.append(len(genomes))
        return score(genomes)

    return counts, counted


def same(a: Population, b: Population) -> bool:
    return all(np.array_equal(x, y) for x, y in zip(a, b, strict=True))


def test_only_new_genomes_are_simulated() -> None:
    counts, score = counting(sphere)
    list(evolve(GENETIC, score, 5))
    assert counts == [40, 20, 20, 20, 20]


@pytest.mark.parametrize("stop", [1, 4, 7])
def test_going_on_from_any_generation_gives_the_same_bits(stop: int) -> None:
    states = list(evolve(GENETIC, sphere, 8))
    kept = Population.from_tree(states[stop - 1].to_tree())
    assert same(list(evolve(GENETIC, sphere, 8, state=kept))[-1], states[-1])
