"""Which geoms of a robot touch each other from the start, and how far apart two geoms are."""

from __future__ import annotations

import mujoco
import numpy as np

from estexp_jax.lanes.collision_pairs import touching_pairs
from estexp_jax.physics.model.robot import Robot

_DEEP = 1e-3
"""Meshes that overlap by more at home, m, were not drawn to touch: MuJoCo fills their hollows."""


def overlapping_bodies(robot: Robot) -> tuple[tuple[int, int], ...]:
    """Pairs of bodies of which a mesh overlaps with what it may touch while the robot is at home, in order.

    None of a robot that floats and its surroundings: it may stand on these.

    Source: MuJoCo documentation, "Meshes": collisions are those of the convex hull.
    """
    model, data, found = robot.model, mujoco.MjData(robot.model), set[tuple[int, int]]()
    mesh = model.geom_type == mujoco.mjtGeom.mjGEOM_MESH
    data.qpos[:] = robot.home()
    mujoco.mj_kinematics(model, data)
    for a, b in touching_pairs(model) if mesh.any() else ():
        one, other = sorted((int(model.geom_bodyid[a]), int(model.geom_bodyid[b])))
        floor = any(model.body_weldid[body] == 0 for body in (one, other))
        if (mesh[a] or mesh[b]) and not (floor and (robot.floats(one) or robot.floats(other))):
            if geom_distance(model, data, a, b, 0.0) < -_DEEP:
                found.add((one, other))
    return tuple(sorted(found))


def geom_distance(model: mujoco.MjModel, data: mujoco.MjData, one: int, other: int, most: float) -> float:
    """Distance of two geoms, m, at most `most`; balls around them, which planes have not, tell most."""
    around = model.geom_rbound[[one, other]]
    if around.all() and np.linalg.norm(data.geom_xpos[one] - data.geom_xpos[other]) > around.sum() + most:
        return most
    return mujoco.mj_geomDistance(model, data, one, other, most, None)
