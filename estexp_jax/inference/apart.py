"""What may touch by a robot's description, but never comes near in its recordings."""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from estexp_jax.physics.robot import Robot
from estexp_jax.physics.touching import touching_pairs

_NEAR = 0.02
"""Parts that come nearer, m, may touch in a simulation that moves a little otherwise."""
_ROWS = 300
"""So many rows of each recording are looked at."""


def kept_apart(robot: Robot, paths: Sequence[np.ndarray]) -> list[tuple[int, int]]:
    """Pairs of bodies whose contacts can be left out: they stayed apart all along.

    Two moving bodies, or one of a robot that is bolted down and one of its surroundings: what floats falls on these.

    Args:
        robot: as described.
        paths: (rows, nq) configurations of each recording.
    """
    model, data = robot.model, mujoco.MjData(robot.model)
    pairs, near = _pairs(robot), set[tuple[int, int]]()
    for path in paths if pairs else ():
        for qpos in path[:: max(1, len(path) // _ROWS)]:
            data.qpos[:] = qpos
            mujoco.mj_kinematics(model, data)
            near |= {
                bodies
                for bodies, geoms in pairs.items()
                if bodies not in near and any(_are_near(model, data, one, other) for one, other in geoms)
            }
    return [bodies for bodies in pairs if bodies not in near] if len(paths) else []


def _are_near(model: mujoco.MjModel, data: mujoco.MjData, one: int, other: int) -> bool:
    """Whether two geoms are; balls around them, which planes have not, tell most that are not."""
    around = model.geom_rbound[[one, other]]
    if around.all() and np.linalg.norm(data.geom_xpos[one] - data.geom_xpos[other]) > around.sum() + _NEAR:
        return False
    return mujoco.mj_geomDistance(model, data, one, other, 2.0 * _NEAR, None) <= _NEAR


def _pairs(robot: Robot) -> dict[tuple[int, int], list[tuple[int, int]]]:
    """Bodies that may touch by their description, and those of their geoms that may."""
    model, found = robot.model, dict[tuple[int, int], list[tuple[int, int]]]()
    for a, b in touching_pairs(model):
        first, second = sorted((int(model.geom_bodyid[a]), int(model.geom_bodyid[b])))
        bodies = first, second
        still = [model.body_weldid[body] == 0 for body in bodies]
        if not any(still) or not robot.floats(bodies[1 - still.index(True)]):
            found.setdefault(bodies, []).append((a, b))
    return found
