"""First motions, under which effects say the same."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

Motion = Callable[[np.ndarray, np.random.Generator], np.ndarray]
"""Times (rows,) and a source of chance to commands (rows, actuators)."""


_BEGIN = 2.5
"""Time in which slow motions begin, s: a jolt would tell more."""


def slow(size: float, joints: int = 1, at: int = 0) -> Motion:
    """Three slow sines at one actuator of several; the others rest."""

    def commands(time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        f, p = rng.uniform(0.06, 0.16, 3), rng.uniform(0.0, 2.0 * np.pi, 3)
        found = np.zeros((len(time), joints))
        begun = np.clip(time / _BEGIN, 0.0, 1.0)
        whole = size / 1.8 * np.sin(2.0 * np.pi * f * time[:, None] + p).sum(axis=1)
        found[:, at] = begun**2 * (3.0 - 2.0 * begun) * whole
        return found

    return commands


def one_way(speed: float) -> Motion:
    """Away from home at about one speed, this way or that, without turning back."""

    def commands(time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        way = speed * rng.uniform(0.9, 1.0) * (1.0 - 2.0 * int(rng.integers(2)))
        return way * time[:, None]

    return commands


def either_way(size: float) -> Motion:
    """All of a torque, one way or the other, for 0.5 to 1.5 s each."""

    def commands(time: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        turns = np.searchsorted(np.cumsum(rng.uniform(0.5, 1.5, 40)), time)
        return size * (1.0 - 2.0 * ((turns + int(rng.integers(2))) % 2))[:, None]

    return commands
