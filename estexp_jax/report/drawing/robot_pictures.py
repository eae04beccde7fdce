"""Models, colours and camera views for pictures of robots."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot

MARK = (0.9, 0.35, 0.1)
"""Colour of changed parts."""
_GHOST = 0.25
"""Opacity of lost parts."""
_SKY = ([0.93, 0.95, 0.98], [0.75, 0.82, 0.9])
_FIT = 2.4
"""Distance of the camera over the radius of the scene, for MuJoCo's field of view of 45 degrees."""
_FROM_ABOVE, _FROM_SIDE, _ASKEW = -60.0, -17.0, 20.0
_WAYS = {"x": 0.0, "y": 90.0, "-x": 180.0, "-y": 270.0}


class View(NamedTuple):
    """A camera's position relative to its target point."""

    distance: float  #: m
    azimuth: float  #: degrees
    elevation: float  #: degrees


def drawn(robot: Robot) -> mujoco.MjModel:
    """A robot's model, with a sky added if it has none."""
    spec = robot.spec.copy()
    if any(texture.type == mujoco.mjtTexture.mjTEXTURE_SKYBOX for texture in spec.textures):
        return spec.compile()
    sky = spec.add_texture(name="estexp_sky", type=mujoco.mjtTexture.mjTEXTURE_SKYBOX, width=64, height=384)
    sky.builtin = mujoco.mjtBuiltin.mjBUILTIN_GRADIENT
    sky.rgb1, sky.rgb2 = _SKY
    return spec.compile()


def colours(robot: Robot, changes: Sequence[Change] = ()) -> np.ndarray:
    """Colours (ngeom, 4) of a robot: changed parts are marked, lost parts are ghosts in that colour."""
    model = robot.model
    rgba = model.geom_rgba.copy()
    for change in changes:
        body = part_at(robot, change.kind, change.name)
        if body is None:
            continue
        gone = effect(change.effect).removes_part
        geoms = np.isin(model.geom_bodyid, robot.subtree(body) if gone else (body,))
        rgba[geoms, :3] = MARK
        if gone:
            rgba[geoms, 3] *= _GHOST
    return rgba


def tinted(robot: Robot, colour: Sequence[float], opacity: float) -> np.ndarray:
    """Colours (ngeom, 4) of a robot in a single colour; the world keeps its colours."""
    rgba = robot.model.geom_rgba.copy()
    moving = robot.model.body_weldid[robot.model.geom_bodyid] != 0
    rgba[moving, :3], rgba[moving, 3] = colour, opacity * (rgba[moving, 3] > 0.0)
    return rgba


def ground_covered(robot: Robot, qpos: np.ndarray) -> tuple[np.ndarray, float]:
    """Centre (3,) and radius, m, of a ball around a robot's moving parts in all of some configurations (n, nq)."""
    model, data = robot.model, mujoco.MjData(robot.model)
    moving = np.flatnonzero((model.body_weldid[model.geom_bodyid] != 0) & (model.geom_rgba[:, 3] > 0.0))
    low, high = np.full(3, np.inf), np.full(3, -np.inf)
    for posture in qpos:
        data.qpos[:] = posture
        mujoco.mj_kinematics(model, data)
        turned = data.geom_xmat[moving].reshape(-1, 3, 3)
        places = data.geom_xpos[moving] + np.matvec(turned, model.geom_aabb[moving, :3])
        reach = np.matvec(np.abs(turned), model.geom_aabb[moving, 3:])
        low, high = np.minimum(low, (places - reach).min(axis=0)), np.maximum(high, (places + reach).max(axis=0))
    if not np.all(np.isfinite(low + high)):
        return np.zeros(3), 1.0
    return (low + high) / 2.0, float(np.linalg.norm(high - low)) / 2.0


def walking_view(axis: str, radius: float) -> View:
    """A view in which a robot that moves along an axis moves to the right."""
    return View(_FIT * radius, (90.0 + _ASKEW + _WAYS[axis]) % 360.0, _FROM_SIDE)


def standing_view(robot: Robot, radius: float) -> View:
    """A view along the joints' axes, so that rotations are visible; slightly rotated, to show depth."""
    data = mujoco.MjData(robot.model)
    data.qpos[:] = robot.home()
    mujoco.mj_kinematics(robot.model, data)
    along = np.abs(data.xaxis[list(robot.scalar_joints)]).sum(axis=0) if robot.scalar_joints else np.array([0, 1, 0])
    if along[2] > along[0] + along[1]:
        return View(_FIT * radius, 90.0 + _ASKEW, _FROM_ABOVE)
    side = float(np.degrees(np.arctan2(along[1], along[0])))
    return View(_FIT * radius, side + _ASKEW, _FROM_SIDE)


def part_at(robot: Robot, kind: str, name: str | None) -> int | None:
    """Id of the body at a place; None for all elements of a kind, and for places without a body."""
    if name is None or name == "*":
        return None
    match kind:
        case "body":
            return robot.index("body", name)
        case "joint":
            return int(robot.model.jnt_bodyid[robot.index("joint", name)])
        case "actuator":
            joint = robot.joint_of_actuator(robot.index("actuator", name))
            return None if joint is None else int(robot.model.jnt_bodyid[joint])
        case "sensor":
            return robot.body_of_sensor(robot.index("sensor", name))
        case _:
            return None
