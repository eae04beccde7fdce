"""Helpers for initial guesses: values between neutral and bounds, from which searches start."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from estexp_jax.physics.effects.sites import driven_joint_sites
from estexp_jax.physics.model.robot import Robot

SHARES = (0.004, 0.04, 0.3)
"""Between neutral and a bound: costs differ in scale by orders of magnitude."""

Vectors = list[tuple[float, ...]]
"""Values of an effect's parameters, in its order."""
Bounds = Sequence[tuple[float, float]]
"""(low, high) of each parameter."""


def towards_bounds(neutral: Sequence[float], bounds: Bounds) -> Vectors:
    """All parameters a little, somewhat and strongly towards their bounds, to either side."""
    nothing, found = tuple(neutral), []
    for share, side in product(SHARES, (1, 0)):
        moved = tuple(n + share * (b[side] - n) for n, b in zip(nothing, bounds, strict=True))
        if moved != nothing:
            found.append(moved)
    return found


def spread(bound: tuple[float, float], n: int) -> list[float]:
    """So many values inside a bound, evenly by factors."""
    return np.geomspace(*bound, n + 2)[1:-1].tolist()


def along_axes(bounds: Bounds, share: float) -> Vectors:
    """One of the first three parameters at a time, to either side."""
    found = []
    for axis, side in product(range(3), (0, 1)):
        values = [0.0] * len(bounds)
        values[axis] = share * bounds[axis][side]
        found.append(tuple(values))
    return found


def other_elements(robot: Robot, kind: str, site: str) -> list[float]:
    """References (1 + index) to every other element of a kind; of joints, to those that a motor drives."""
    names = robot.names(kind)
    choices = driven_joint_sites(robot) if kind == "joint" else names
    return [1.0 + i for i, name in enumerate(names) if name != site and name in choices]
