"""How speed depends on the size of the population."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from time import perf_counter
from typing import Any

import numpy as np

from estexp_jax.benchmark.engines import Made, Runner
from estexp_jax.benchmark.subject import BenchmarkRobots, BenchmarkTask
from estexp_jax.physics.engines.lanes.closed_loop import lanes_width
from estexp_jax.runs import ProgressDisplay

POPULATIONS = (1, 2, 4, 8, 16, 32, 64, 100, 128, 200, 256, 400, 512, 800, 1024, 1600, 2048, 3200, 4096, 6400)
FEW = {"mjx": (1, 50, 200, 800), "batch": (1, 8, 64, 200, 800, 3200), "lanes": POPULATIONS}
"""Populations of each engine that is swept; C without its pool does not depend on it."""
_ROWS, _LEAST_S, _MOST, _ROUNDS = 100, 0.2, 500_000, 3


def sweep(
    race: BenchmarkTask, names: Sequence[str], progress: ProgressDisplay, made: Made, largest: int = 6400
) -> list[dict[str, Any]]:
    """Robot steps per second over the population, each point the median of some rounds through all points.

    Args:
        race: robot, substeps, seed.
        names: engines to take, of those in `FEW`.
        progress: shows how far it is.
        made: gives an engine by name.
        largest: population.

    Returns:
        One entry a point: `engine`, `robots`, `robot_steps_per_s`, and `share_of_neighbours`: its rate over that
        interpolated between the populations next to it, on logarithmic axes; None at the ends.
    """
    points = [(name, n) for name in FEW if name in names for n in FEW[name] if n <= largest]
    steps = min(_ROWS, race.steps)
    cast = _cast(replace(race, steps=steps), points, progress, made)
    progress.stage("sweep: timing", _ROUNDS * len(points))
    rates: dict[tuple[str, int], list[float]] = {point: [] for point in points}
    for _ in range(_ROUNDS):
        for point in points:
            rates[point].append(_rate(cast[point], point[1], steps, race.substeps))
            progress.advance(note=f"{point[0]}, {point[1]} robots: {rates[point][-1]:,.0f} steps/s")
    found = [{"engine": e, "robots": n, "robot_steps_per_s": float(np.median(rates[e, n]))} for e, n in points]
    return [{**one, "share_of_neighbours": _share(one, found)} for one in found]


def _cast(
    race: BenchmarkTask, points: Sequence[tuple[str, int]], progress: ProgressDisplay, made: Made
) -> dict[Any, Runner]:
    """An engine for each point, warm; lanes whose chunks are equally wide share one executable, as does all of MJX."""
    groups: dict[Any, list[tuple[str, int]]] = {}
    for name, n in points:
        same = {"mjx": 0, "lanes": lanes_width(2 * n)}.get(name, n)
        groups.setdefault((name, same), []).append((name, n))
    cast: dict[Any, Runner] = {}
    progress.stage("sweep: compiling", len(groups))
    for (name, _), members in groups.items():
        each = made(name, BenchmarkRobots(replace(race, population=max(n for _, n in members))))
        for point in members:
            each.simulate(point[1], 1)
            cast[point] = each
        progress.advance(note=f"{name}, {members[-1][1]} robots")
    return cast


def _rate(each: Runner, robots: int, steps: int, substeps: int) -> float:
    """Robot steps per second, over as many rollouts as take a fifth of a second."""
    steps = int(np.clip(_MOST // (robots * substeps), 1, steps))
    begin, rollouts = perf_counter(), 0
    while True:
        each.simulate(robots, steps)
        rollouts += 1
        if (spent := perf_counter() - begin) >= _LEAST_S:
            return rollouts * robots * steps * substeps / spent


def _share(one: dict[str, Any], found: Sequence[dict[str, Any]]) -> float | None:
    line = [x for x in found if x["engine"] == one["engine"]]
    i = line.index(one)
    if not 0 < i < len(line) - 1:
        return None
    at = [np.log(x["robots"]) for x in line[i - 1 : i + 2]]
    rates = [np.log(x["robot_steps_per_s"]) for x in line[i - 1 : i + 2]]
    between = np.interp(at[1], [at[0], at[2]], [rates[0], rates[2]])
    return float(np.exp(rates[1] - between))
