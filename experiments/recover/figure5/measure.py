"""Walks of damaged robots under the same controllers, and how their readings part."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.metrics import distance_error, rolling_mean
from estexp_jax.recovery.simulator import damage_simulator
from estexp_jax.runs import enable_compilation_cache, load_checkpoint, save_checkpoint
from experiments.harness.world import quadruped
from experiments.recover.diagnosis.task import library

HEADERS = (12, 20, 30, 50, 100, 200, 500, 999)
WINDOWS = (2, 10, "h / 2")
LOSSES = tuple(np.round(np.arange(0.0, 1.0, 0.1), 1))
TRUE_LOSS = 0.5
"""The robot in the world has lost so much of one motor; hypotheses have lost `LOSSES` of it."""
_DIFFERENT, _OVER = 0.1, 10
"""Two robots have parted when their angles, over so many steps and all legs, differ by so much on average (1: 45
degrees). Touch does not count: a faulty sensor's own reading differs from the start."""


def traces(n: int, steps: int, file: Path) -> dict[str, Any]:
    """Inputs (walkers, robots, steps, sensors) and distances (walkers, robots); kept in a file.

    Robots: one motor weaker by 10 %, by 20 %, a touch sensor failed by 50 %, then the same motor by each of `LOSSES`.
    """
    if file.is_file():
        return load_checkpoint(file)
    enable_compilation_cache()
    world = damage_simulator(quadruped(), Settings(population=200, steps=steps))
    random, sets, weights = np.random.default_rng(5000), [], []
    for walker in library()[:n]:
        motor, touch = str(random.choice(quadruped().names("actuator"))), f"touch_{random.choice(list('flbr'))}"
        losses = [0.1, 0.2, None, *LOSSES]
        weak = [[Change("motor_weakness", motor, {"loss": float(x)})] for x in losses if x is not None]
        sets += [*weak[:2], [Change("sensor_gain", touch, {"gain": 0.5})], *weak[2:]]
        weights += [walker] * (3 + len(LOSSES))
    walk = world.rollout_each(sets, np.array(weights), steps)
    shape = (n, 3 + len(LOSSES))
    inputs = np.asarray(world.closed_loop.interface.inputs(walk.readings)).reshape(*shape, steps, -1)
    distance = (walk.position[:, -1, 0] - walk.position[:, 0, 0]).reshape(shape)
    save_checkpoint(file, {"inputs": inputs.astype(np.float32), "distance": np.asarray(distance)})
    return load_checkpoint(file)


def divergences(found: dict[str, Any]) -> list[dict[str, Any]]:
    """A row for each controller: when similar and unlike robots part, control steps; the last where they never do."""
    x = found["inputs"]
    pairs = {"similar": (x[:, 0], x[:, 1]), "unlike": (x[:, 0], x[:, 2])}
    times = {name: _parting(a, b) for name, (a, b) in pairs.items()}
    return [{"controller": i, **{name: int(t[i]) for name, t in times.items()}} for i in range(len(x))]


def _parting(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    angles = ~interface_of(quadruped()).is_touch
    difference = np.mean(np.abs(a - b)[..., angles], axis=-1)
    smooth = np.apply_along_axis(lambda d: np.convolve(d, np.ones(_OVER) / _OVER, mode="valid"), 1, difference)
    different = smooth > _DIFFERENT
    return np.where(different.any(axis=1), different.argmax(axis=1), smooth.shape[1])


def correlations(found: dict[str, Any], headers: list[int]) -> list[dict[str, Any]]:
    """Spearman's correlation, over hypotheses, of the metric with how far their loss is from the true one.

    A row for each h and w: mean over the controllers. And one for the distance, equation 1.
    """
    true = 3 + LOSSES.index(TRUE_LOSS)
    x, away = found["inputs"], np.abs(np.array(LOSSES) - TRUE_LOSS)
    others, rows = np.flatnonzero(away > 0.0), []
    for h in headers:
        for w in WINDOWS:
            window = 2 * (h // 4) if w == "h / 2" else int(w)
            values = [rolling_mean(one[true][None], one[3 + others][:, None], header=h, window=window) for one in x]
            rows.append(
                {"metric": "rolling mean", "h": h, "w": str(w), **_mean([_rank(v, away[others]) for v in values])}
            )
    distances = [distance_error(d[true : true + 1], d[3 + others][:, None]) for d in found["distance"]]
    rank = _mean([_rank(v, away[others]) for v in distances])
    rows.append({"metric": "distance", "h": x.shape[2], "w": "", **rank})
    return rows


def _rank(values: np.ndarray, away: np.ndarray) -> float:
    return float(stats.spearmanr(values, away).statistic) if np.ptp(values) > 0.0 else np.nan  # pyright: ignore


def _mean(values: list[float]) -> dict[str, float]:
    x = np.array(values)
    x = x[np.isfinite(x)]
    return {"correlation": float(x.mean()), "standard_error": float(x.std(ddof=1) / np.sqrt(len(x))), "n": len(x)}
