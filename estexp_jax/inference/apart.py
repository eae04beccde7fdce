"""Parts of a robot that may touch each other by its description, but never come near in its recordings."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import mujoco
import numpy as np

from estexp_jax.physics.robot import Robot

_NEAR = 0.02
"""Parts that come nearer, m, may touch in a simulation that moves a little otherwise."""
_ROWS = 300
"""So many rows of each recording are looked at."""


def kept_apart(robot: Robot, paths: Sequence[np.ndarray]) -> list[tuple[int, int]]:
    """Pairs of moving bodies whose contacts can be left out: they stayed apart all along.

    Args:
        robot: as described.
        paths: (rows, nq) configurations of each recording.
    """
    model, data = robot.model, mujoco.MjData(robot.model)
    nearest: dict[tuple[int, int], float] = {}
    pairs = _pairs(model)
    for path in paths if pairs else ():
        for qpos in path[:: max(1, len(path) // _ROWS)]:
            data.qpos[:] = qpos
            mujoco.mj_kinematics(model, data)
            for one, other in pairs:
                bodies = int(model.geom_bodyid[one]), int(model.geom_bodyid[other])
                distance = mujoco.mj_geomDistance(model, data, one, other, 2.0 * _NEAR, None)
                nearest[bodies] = min(nearest.get(bodies, np.inf), distance)
    return [bodies for bodies, distance in nearest.items() if distance > _NEAR]


def _pairs(model: mujoco.MjModel) -> list[tuple[int, int]]:
    """Geoms of two moving bodies that collide by their description."""
    moving = [g for g in range(model.ngeom) if model.body_weldid[model.geom_bodyid[g]] != 0]
    collide = model.geom_contype[:, None] & model.geom_conaffinity[None, :]
    return [
        (a, b)
        for a, b in combinations(moving, 2)
        if model.geom_bodyid[a] != model.geom_bodyid[b] and (collide[a, b] or collide[b, a])
    ]


def excluded(robot: Robot, bodies: Sequence[tuple[int, int]]) -> Robot:
    """The robot without contacts between some pairs of its bodies."""
    if not bodies:
        return robot
    spec, names = robot.spec.copy(), robot.names("body")
    for one, other in bodies:
        spec.add_exclude(bodyname1=names[one], bodyname2=names[other])
    return Robot.from_spec(spec, robot.source)
