"""Runs a genetic algorithm generation by generation, from any of its states."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from estexp_jax.search.genetic import Genetic, Population, ask_genetic, begin_genetic, tell_genetic

Score = Callable[[np.ndarray], np.ndarray]
"""Maps genomes (n, length) to scores (n,): lower is better, not finite where the simulation diverged."""


def evolve(
    genetic: Genetic,
    score: Score,
    generations: int,
    *,
    seeds: Sequence[np.ndarray] = (),
    state: Population | None = None,
) -> Iterator[Population]:
    """Yield the population after each generation.

    Args:
        genetic: the algorithm's settings.
        score: of genomes.
        generations: in total, including those of `state`.
        seeds: (length,) genomes of the first generation.
        state: an earlier generation to resume from.
    """
    state = begin_genetic(genetic) if state is None else state
    while state.generation < generations:
        genomes = ask_genetic(genetic, state, seeds)
        state = tell_genetic(genetic, state, genomes, score(genomes))
        yield state
