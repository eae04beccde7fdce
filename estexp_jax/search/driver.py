"""Runs a search generation by generation, from any of its states."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from estexp_jax.search.genetic import Genetic, Population, ask_genetic, begin_genetic, tell_genetic

Score = Callable[[np.ndarray], np.ndarray]
"""Genomes (n, length) to scores (n,), lower is better, not finite where the simulation blew up."""


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
        score: the simulation.
        generations: in all, those of `state` included.
        seeds: (length,) genomes for the first generation.
        state: an earlier one to go on from.
    """
    state = begin_genetic(genetic) if state is None else state
    while state.generation < generations:
        genomes = ask_genetic(genetic, state, seeds)
        state = tell_genetic(genetic, state, genomes, score(genomes))
        yield state
