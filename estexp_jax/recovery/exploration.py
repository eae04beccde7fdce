"""The exploration phase: evolve a controller that carries the simulated robot far.

Sources: Bongard and Lipson 2004, section 2.2, "The Exploration Phase"; several simulators that differ at random, so
that a controller also works outside them: Jakobi, Evolutionary robotics and the radical envelope of noise hypothesis
(1997).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from estexp_jax.physics.changes import Change
from estexp_jax.physics.engines.walking import Heard
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.perturbation import ensemble, noise
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
    """Score of controllers on the robot as diagnosed: minus the distance along the axis, m; +inf if it blew up.

    Where the simulator is rough, each walks on several that differ as much as it may be off, with noisy sensors, and
    the mean distance counts: what exploits one simulator's errors loses its way on the others, as on the robot.
    """
    sets: list[tuple[Change, ...]] = [tuple(changes)]
    heard: Heard | None = None
    if settings.members > 1:
        sets = [(*changes, *member) for member in ensemble(simulator.robot, settings.rough, settings.members)]
        told = noise(simulator.walker.interface, settings.members, settings.steps)
        heard = Heard(told.factor[:, None], told.added[:, None])
    start = simulator.settled(sets)

    def score(weights: np.ndarray) -> np.ndarray:
        walk = simulator.walks(sets, start, weights, settings.steps, heard)
        mean = np.mean(distances(walk.position, settings.axis), axis=0)
        return np.where(np.any(walk.failed, axis=0), np.inf, -mean)

    return score
