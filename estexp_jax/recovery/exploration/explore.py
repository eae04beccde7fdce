"""The exploration phase: evolve a controller that moves the simulated robot far.

Sources: Bongard and Lipson 2004, section 2.2, "The Exploration Phase". Random variation of the simulators, so that
controllers transfer to the robot: Jakobi, Evolutionary robotics and the radical envelope of noise hypothesis (1997).
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
_VALIDATION_SIMULATORS = 32
"""Simulators that validate controllers after the search. On development seeds the robot then went a tenth farther."""


def exploration_algorithm(simulator: DamageSimulator, settings: Settings, number: int) -> Genetic:
    """The genetic algorithm of pass `number`, counted from 0."""
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
    """The score function of controllers on the robot as diagnosed.

    It maps weights (n, n_weights) to minus the distances along the axis (n,), m; +inf where a simulation diverged. If
    the simulator has errors, the mean over several perturbed simulators with noisy sensors counts. A controller that
    exploits the errors of one simulator then fails on the others, as it would on the robot.

    Args:
        simulator: of the robot.
        settings: of the run.
        changes: the diagnosis.
        draw: number of the draw of perturbed simulators; each gives others.
    """
    sets: list[tuple[Change, ...]] = [tuple(changes)]
    noise: ReadingOverride | None = None
    if settings.ensemble_size > 1:
        perturbed = perturbed_robots(simulator.robot, settings.relative_error, settings.ensemble_size, draw)
        sets = [(*changes, *member) for member in perturbed]
        noise_of = sensor_noise(simulator.closed_loop.interface, settings.ensemble_size, settings.steps, draw)
        noise = ReadingOverride(noise_of.factor[:, None], noise_of.added[:, None])
    start = simulator.settled(sets)

    def score(weights: np.ndarray) -> np.ndarray:
        rollout = simulator.rollouts(sets, start, weights, settings.steps, noise)
        mean = np.mean(distances_along(rollout.position, settings.axis), axis=0)
        return np.where(np.any(rollout.failed, axis=0), np.inf, -mean)

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
    """Candidates for the next trial with their scores, best first.

    For an exact simulator these are the last generation. Otherwise its better half is evaluated anew on further
    perturbed simulators, because the best of many is overfitted to those of the search. Controllers that the robot has
    tried are candidates for the last trial only: before it, they would give no new information.

    Args:
        simulator: of the robot.
        settings: of the run.
        changes: the diagnosis.
        population: the last generation.
        tried: controllers (n_weights,) of the trials before.
        last: whether the last trial is chosen.

    Returns:
        Genomes (n, n_weights) and scores (n,).
    """
    if settings.ensemble_size == 1:
        return population.genomes, population.scores
    known = {w.tobytes() for w in tried}
    new = [w for w in population.genomes if w.tobytes() not in known] or list(population.genomes)
    n = len(population.genomes) - len(population.genomes) // 2  # the batch size of a generation: already compiled
    again = list(tried)[-(n // 2) :] if last else []
    genomes = np.array([*new[: n - len(again)], *again])
    draws = range(1, validation_ensemble(settings) + 1)
    scores = np.mean([exploration_score(simulator, settings, changes, i)(genomes) for i in draws], axis=0)
    order = np.argsort(scores, kind="stable")
    return genomes[order], scores[order]


def validation_ensemble(settings: Settings) -> int:
    """Number of further ensembles, each as large as that of the search, that validate controllers after it."""
    return 0 if settings.ensemble_size == 1 else max(1, round(_VALIDATION_SIMULATORS / settings.ensemble_size))
