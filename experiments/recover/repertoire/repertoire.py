"""Recovery without diagnosis: a map of diverse gaits from simulation, tried one after the other by Bayesian choice.

MAP-Elites keeps the farthest walker of each cell of gaits, a gait being the share of time that each foot is on the
ground. On the damaged robot a Gaussian process, whose mean is the map, learns from each trial which gaits still work.

Sources: Mouret and Clune, Illuminating search spaces by mapping elites (2015); Cully, Clune, Tarapore and Mouret,
Robots that can adapt like animals, Nature 521 (2015), whose kernel and constants these are.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from estexp_jax.physics.engines.closed_loop import ReadingOverride
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import distances_along
from estexp_jax.recovery.model_error import perturbed_robots, sensor_noise
from estexp_jax.recovery.simulator import DamageSimulator

_LEVELS = 5
"""Of the share of time that a foot is on the ground."""
_TAG = 61
_LENGTH, _NOISE, _CURIOUS = 0.4, 0.001, 0.05
"""Of the Gaussian process: length of the Matern kernel, variance of a trial (distances as shares of the map's best),
and deviations by which an untried gait is preferred."""


@dataclass(frozen=True)
class Repertoire:
    """Gaits, one for each cell that has any.

    Attributes:
        weights: (gaits, n_weights).
        duty: (gaits, feet) share of time on the ground.
        distance: (gaits,) in simulation, m.
    """

    weights: np.ndarray
    duty: np.ndarray
    distance: np.ndarray


def evolved(simulator: DamageSimulator, settings: Settings, walks: int) -> Iterator[Repertoire]:
    """The map after each generation, within a budget.

    Args:
        simulator: of the healthy robot.
        settings: of the run; a generation is as large as its genetic algorithm's, a walk as long.
        rollouts: simulated in all; where the simulator is rough, each is one on several simulators.
    """
    found: dict[tuple[int, ...], tuple[np.ndarray, np.ndarray, float]] = {}
    sets, readings_noise = _simulators(simulator, settings)
    start, generation = simulator.settled(sets), 0
    while walks > 0:
        random = np.random.default_rng([settings.seed, _TAG, generation])
        n = min(settings.population if generation == 0 else settings.population // 2, walks)
        weights = _children([w for w, _, _ in found.values()], n, simulator.n_weights, settings.mutation, random)
        walk = simulator.rollouts(sets, start, weights, settings.steps, readings_noise)
        far = np.mean(distances_along(walk.position, settings.axis), axis=0)
        down = np.asarray(walk.readings)[..., simulator.closed_loop.interface.is_touch] > 0.0
        duty = np.mean(down, axis=(0, 2))
        for own, gait, came, failed in zip(weights, duty, far, np.any(walk.failed, axis=0), strict=True):
            cell = tuple(np.minimum((gait * _LEVELS).astype(int), _LEVELS - 1).tolist())
            if not failed and (cell not in found or came > found[cell][2]):
                found[cell] = (own, gait, float(came))
        walks, generation = walks - n, generation + 1
        yield Repertoire(*(np.array(column) for column in zip(*found.values(), strict=True)))


def _simulators(simulator: DamageSimulator, settings: Settings) -> tuple[list, ReadingOverride | None]:
    """What exploration simulates, too: the nominal robot, or several that differ as much as it may be off."""
    if settings.ensemble_size == 1:
        return [()], None
    noises = sensor_noise(simulator.closed_loop.interface, settings.ensemble_size, settings.steps)
    members = perturbed_robots(simulator.robot, settings.relative_error, settings.ensemble_size)
    return list(members), ReadingOverride(noises.factor[:, None], noises.added[:, None])


def _children(
    parents: list[np.ndarray], n: int, length: int, mutation: float, random: np.random.Generator
) -> np.ndarray:
    """Random weights at first; then elites drawn evenly, each value drawn anew with a chance, at least one of them."""
    fresh = random.integers(-100, 101, size=(n, length)) / 100
    if not parents:
        return fresh
    mutated = random.random((n, length)) < mutation
    mutated[np.arange(n), random.integers(length, size=n)] = True
    return np.where(mutated, fresh, np.array(parents)[random.integers(len(parents), size=n)])


def adapted(repertoire: Repertoire, trial: Callable[[np.ndarray], float], trials: int) -> list[tuple[int, float]]:
    """Gaits that are tried one after the other, and how far each comes, m.

    Args:
        repertoire: the map.
        trial: a controller (n_weights,) on the robot.
        trials: how many, at most as many as there are gaits.
    """
    unit = max(float(np.max(repertoire.distance)), 1e-6)
    prior, tried = repertoire.distance / unit, list[tuple[int, float]]()
    while len(tried) < min(trials, len(prior)):
        mean, deviation = believed(prior, repertoire.duty, [(i, d / unit) for i, d in tried])
        hope = mean + _CURIOUS * deviation
        hope[[i for i, _ in tried]] = -np.inf
        best = int(np.argmax(hope))
        tried.append((best, float(trial(repertoire.weights[best]))))
    return tried


def believed(prior: np.ndarray, gaits: np.ndarray, trials: list[tuple[int, float]]) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard deviation (gaits,) of a Gaussian process about a prior mean, after some trials.

    Args:
        prior: (gaits,) mean.
        gaits: (gaits, dimensions) in [0, 1].
        trials: indices of gaits that were tried, with what came of them.
    """
    if not trials:
        return prior, np.ones(len(prior))
    at = np.array([i for i, _ in trials])
    values = np.array([v for _, v in trials])
    across = _matern(gaits, gaits[at])
    gain = np.linalg.solve(across[at] + _NOISE * np.eye(len(at)), across.T).T
    variance = 1.0 - np.sum(gain * across, axis=1)
    return prior + gain @ (values - prior[at]), np.sqrt(np.maximum(variance, 0.0))


def _matern(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Matern kernel of 5/2 between points (n, d) and (m, d)."""
    r = np.sqrt(5.0) * np.linalg.norm(a[:, None] - b[None], axis=2) / _LENGTH
    return (1.0 + r + r**2 / 3.0) * np.exp(-r)
