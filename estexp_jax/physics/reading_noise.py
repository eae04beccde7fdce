"""Noise of a single reading, from its samples alone, and whether it holds still but for that."""

from __future__ import annotations

import numpy as np

from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_ORDERS = (3, 4, 5, 6)
_STILL = 5.0
"""Deviations of its noise by which a sensor that is stuck may still waver."""


def noise_std_of(time: np.ndarray, samples: np.ndarray) -> float:
    """Standard deviation of the noise in a slowly changing signal, in its unit; NaN for fewer than five samples.

    Divided differences of order d remove motion that is locally a polynomial of lower degree, on any clock. They are
    scaled so that white noise keeps its standard deviation; the median is robust against jolts. The least of several
    orders is taken, because low orders leave some of a fast motion that is sampled slowly. A quantised signal at rest
    has no differences, so the result is at least step / sqrt(12).

    Args:
        time: (rows,) s, increasing.
        samples: (rows,), NaN where there is no sample.
    """
    good = np.isfinite(samples)
    t, y = time[good], samples[good]
    if len(y) < 5:
        return float("nan")
    spread = min(_typical_difference(t, y, d) for d in _ORDERS if d < len(y) - 1)
    return max(spread, _quantum(y) / np.sqrt(12.0))


def holds_still(robot: Robot, recording: Recording, sensor: str, begin: float) -> bool:
    """Whether a sensor holds still but for its noise, from a share of a recording on."""
    column = int(robot.model.sensor_adr[robot.index("sensor", sensor)])
    rows = slice(int(begin * recording.rows), None)
    time, samples = recording.time[rows], recording.sensor[rows, column]
    known = samples[np.isfinite(samples)]
    if len(known) < 5:
        return True
    rounding = 1e-9 * float(np.abs(known).max())
    return bool(known.std() <= _STILL * noise_std_of(time, samples) + rounding)


def _typical_difference(time: np.ndarray, samples: np.ndarray, order: int) -> float:
    """Standard deviation of white noise that has divided differences of an order of the same median size."""
    near = np.arange(len(time) - order)[:, None] + np.arange(order + 1)
    separations = time[near][:, :, None] - time[near][:, None, :] + np.eye(order + 1)
    weights = 1.0 / np.prod(separations / np.abs(separations).max(axis=(1, 2), keepdims=True), axis=2)
    weights /= np.linalg.norm(weights, axis=1, keepdims=True)
    return float(np.median(np.abs(np.sum(weights * samples[near], axis=1)))) / 0.6745


def _quantum(y: np.ndarray) -> float:
    """The quantisation step, if few distinct values recur; else 0."""
    values = np.unique(y)
    if len(values) < 2 or len(values) > 0.5 * len(y):
        return 0.0
    return float(np.median(np.diff(values)))
