"""Which geoms of a model may touch each other, and which do so from the start."""

from __future__ import annotations

import mujoco
import numpy as np

from estexp_jax.physics.robot import Robot

_DEEP = 1e-3
"""Meshes that overlap by more at home, m, were not drawn to touch: MuJoCo fills their hollows."""


def contacts_on(model: mujoco.MjModel) -> bool:
    """Whether a model's options leave contacts on at all."""
    return not model.opt.disableflags & (mujoco.mjtDisableBit.mjDSBL_CONTACT | mujoco.mjtDisableBit.mjDSBL_CONSTRAINT)


def touching_pairs(model: mujoco.MjModel) -> list[tuple[int, int]]:
    """Pairs of geoms that MuJoCo lets collide, a plane first.

    Source: MuJoCo documentation, "Collision detection", "Filtering".
    """
    excluded = {tuple(sorted(((s >> 16) & 0xFFFF, s & 0xFFFF))) for s in model.exclude_signature.tolist()}
    pairs = []
    for a in range(model.ngeom):
        for b in range(a + 1, model.ngeom):
            if _may_touch(model, a, b, excluded):
                plane_second = int(model.geom_type[b]) == mujoco.mjtGeom.mjGEOM_PLANE
                pairs.append((b, a) if plane_second else (a, b))
    return pairs


def _may_touch(model: mujoco.MjModel, a: int, b: int, excluded: set) -> bool:
    if not (model.geom_contype[a] & model.geom_conaffinity[b] or model.geom_contype[b] & model.geom_conaffinity[a]):
        return False
    one, two = int(model.geom_bodyid[a]), int(model.geom_bodyid[b])
    weld = model.body_weldid
    if weld[one] == weld[two] or tuple(sorted((one, two))) in excluded:
        return False
    filters = not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_FILTERPARENT
    parents = [int(weld[model.body_parentid[weld[x]]]) for x in (one, two)]
    joined = weld[one] and weld[two] and (parents[0] == weld[two] or parents[1] == weld[one])
    return not (filters and joined)


def overlapping(robot: Robot) -> tuple[tuple[int, int], ...]:
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
            if gap(model, data, a, b, 0.0) < -_DEEP:
                found.add((one, other))
    return tuple(sorted(found))


def gap(model: mujoco.MjModel, data: mujoco.MjData, one: int, other: int, most: float) -> float:
    """Distance of two geoms, m, at most `most`; balls around them, which planes have not, tell most."""
    around = model.geom_rbound[[one, other]]
    if around.all() and np.linalg.norm(data.geom_xpos[one] - data.geom_xpos[other]) > around.sum() + most:
        return most
    return mujoco.mj_geomDistance(model, data, one, other, most, None)
