"""The exploration phase: evolve a controller that carries the simulated robot far.

Sources: Bongard and Lipson 2004, section 2.2, "The Exploration Phase"; several simulators that differ at random, so
that a controller also works outside them: Jakobi, Evolutionary robotics and the radical envelope of noise hypothesis
(1997).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.engines.closed_loop import ReadingOverride
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import distances_along
from estexp_jax.recovery.model_error import perturbed_robots, sensor_noise
from estexp_jax.recovery.simulator import DamageSimulator
from estexp_jax.search.genetic import Genetic, Population

TAG = 1
_JURY = 32
"""Simulators that judge after the search. Seen on development seeds: with them the robot comes a tenth farther."""


def exploration_algorithm(simulator: DamageSimulator, settings: Settings, number: int) -> Genetic:
    """The genetic algorithm of one pass, counted from 0."""
    return Genetic(
        length=simulator.n_weights,
        population=settings.population,
        seed=settings.seed,
        tags=(TAG, number),
        mutation=settings.mutation,
    )


def exploration_score(
    simulator: DamageSimulator, settings: Settings, changes: Sequence[Change], draw: int = 0
) -> Callable[[np.ndarray], np.ndarray]:
    """Score of controllers on the robot as diagnosed: minus the distance along the axis, m; +inf if it blew up.

    Where the simulator is rough, each walks on several that differ as much as it may be off, with noisy sensors, and
    the mean distance counts: what exploits one simulator's errors loses its way on the others, as on the robot.

    Args:
        simulator: of the robot.
        settings: of the run.
        changes: the diagnosis.
        draw: of the rough simulators; others for each number.
    """
    sets: list[tuple[Change, ...]] = [tuple(changes)]
    heard: ReadingOverride | None = None
    if settings.members > 1:
        off = perturbed_robots(simulator.robot, settings.rough, settings.members, draw)
        sets = [(*changes, *member) for member in off]
        told = sensor_noise(simulator.walker.interface, settings.members, settings.steps, draw)
        heard = ReadingOverride(told.factor[:, None], told.added[:, None])
    start = simulator.settled(sets)

    def score(weights: np.ndarray) -> np.ndarray:
        walk = simulator.walks(sets, start, weights, settings.steps, heard)
        mean = np.mean(distances_along(walk.position, settings.axis), axis=0)
        return np.where(np.any(walk.failed, axis=0), np.inf, -mean)

    return score


def rank_controllers(
    simulator: DamageSimulator,
    settings: Settings,
    changes: Sequence[Change],
    population: Population,
    tried: Sequence[np.ndarray],
    *,
    last: bool,
) -> tuple[np.ndarray, np.ndarray]:
    """What the next trial is chosen from, and the scores, best first: the last generation of an exact simulator.

    The best of many is best on the simulators that it was selected on, less so on the robot. Where the simulator is
    rough, a jury of others judges the generation's better half anew. The last trial may be one that the robot has had,
    if nothing new promises more; before that, it would teach nothing.

    Args:
        simulator: of the robot.
        settings: of the run.
        changes: the diagnosis.
        population: the last generation.
        tried: controllers (n_weights,) of the trials before.
        last: whether it is for the last trial.
    """
    if settings.members == 1:
        return population.genomes, population.scores
    known = {w.tobytes() for w in tried}
    new = [w for w in population.genomes if w.tobytes() not in known] or list(population.genomes)
    n = len(population.genomes) - len(population.genomes) // 2  # as many as are new in a generation: compiled already
    again = list(tried)[-(n // 2) :] if last else []
    genomes = np.array([*new[: n - len(again)], *again])
    draws = range(1, validation_ensemble(settings) + 1)
    scores = np.mean([exploration_score(simulator, settings, changes, i)(genomes) for i in draws], axis=0)
    order = np.argsort(scores, kind="stable")
    return genomes[order], scores[order]


def validation_ensemble(settings: Settings) -> int:
    """Sets of rough simulators, as large as that of the search, on which controllers are judged after it."""
    return 0 if settings.members == 1 else max(1, round(_JURY / settings.members))
