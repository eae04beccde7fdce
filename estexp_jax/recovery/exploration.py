"""The exploration phase: evolve a controller that carries the simulated robot far.

Source: Bongard and Lipson 2004, section 2.2, "The Exploration Phase".
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from estexp_jax.physics.changes import Change
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.simulator import Simulator
from estexp_jax.recovery.trial import distances
from estexp_jax.search.genetic import Genetic

TAG = 1


def exploration_algorithm(simulator: Simulator, settings: Settings, number: int) -> Genetic:
    """The genetic algorithm of one pass, counted from 0."""
    return Genetic(
        length=simulator.n_weights,
        population=settings.population,
        seed=settings.seed,
        tags=(TAG, number),
        mutation=settings.mutation,
    )


def exploration_score(
    simulator: Simulator, settings: Settings, changes: Sequence[Change]
) -> Callable[[np.ndarray], np.ndarray]:
    """Score of controllers on the robot as diagnosed: minus the distance along the axis, m; +inf if it blew up."""
    start = simulator.settled([changes])

    def score(weights: np.ndarray) -> np.ndarray:
        walk = simulator.walks(changes, start, weights, settings.steps)
        return np.where(walk.failed, np.inf, -distances(walk.position, settings.axis))

    return score
