"""How long one generation of the estimation phase takes, once compiled."""

from __future__ import annotations

from time import perf_counter
from typing import Any

import jax
import numpy as np

from estexp_jax.benchmark.subject import BenchmarkTask, load, small_changes
from estexp_jax.physics.effects.changes import encode, stack
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.simulator import damage_simulator

_TRIALS, _SAMPLES = 4, 21
"""Of a generation at its largest: controllers, control steps."""


def estimation_time(race: BenchmarkTask, repeats: int) -> dict[str, Any]:
    """Time of one generation of the estimation phase once compiled: each genome under each of four controllers.

    Returns:
        `walks_s`: the walks; `generation_s`: with the robots' edits prepared and all settled on the ground before.
    """
    robot, rng = load(race.model, feet=race.feet), np.random.default_rng(race.seed)
    settings = Settings(population=max(4, race.population))
    world = damage_simulator(robot, settings)
    sets = [small_changes(robot, rng) for _ in range(settings.population)]
    weights = rng.uniform(-1.0, 1.0, (_TRIALS, world.n_weights)).astype(np.float32)
    start = jax.tree.map(lambda x: np.repeat(x, _TRIALS, axis=0), world.settled(sets))
    few = stack([encode(robot, world.closed_loop.catalogue, changes) for changes in sets])
    values = {name: np.repeat(array, _TRIALS, axis=0) for name, array in few.items()}
    many = np.tile(weights, (len(sets), 1))
    world.closed_loop.rollout(values, many, start, _SAMPLES)
    rollouts, whole = [], []
    for _ in range(max(repeats, 3)):
        begin = perf_counter()
        world.closed_loop.rollout(values, many, start, _SAMPLES)
        between = perf_counter()
        world.trials(sets, weights, _SAMPLES)
        rollouts.append(between - begin)
        whole.append(perf_counter() - between)
    robot_steps = len(many) * _SAMPLES * world.closed_loop.substeps
    return {
        "engine": world.closed_loop.choice.engine,
        "genomes": len(sets),
        "controllers": _TRIALS,
        "steps": _SAMPLES,
        "substeps": world.closed_loop.substeps,
        "robot_steps": robot_steps,
        "walks_s": float(np.median(rollouts)),
        "generation_s": float(np.median(whole)),
        "settle_steps": settings.settle_steps,
    }
