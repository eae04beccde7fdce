"""Bodies that a model welds to the world and that may give: what carries a robot, and how it and the robot move.

Vectors are three numbers or arrays, in world axes; a symmetric matrix is six: xx, yy, zz, xy, xz, yz.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, NamedTuple

import mujoco
import numpy as np

from estexp_jax.physics.model.robot import Robot

Vector = tuple[Any, Any, Any]
Symmetric = tuple[Any, Any, Any, Any, Any, Any]

_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))
_SENSOR = mujoco.mjtSensor
_OF_MOTION = tuple(
    int(s)
    for s in (
        *(_SENSOR.mjSENS_GYRO, _SENSOR.mjSENS_ACCELEROMETER, _SENSOR.mjSENS_VELOCIMETER, _SENSOR.mjSENS_MAGNETOMETER),
        *(_SENSOR.mjSENS_FRAMEPOS, _SENSOR.mjSENS_FRAMEQUAT, _SENSOR.mjSENS_FRAMELINVEL, _SENSOR.mjSENS_FRAMEANGVEL),
        *(_SENSOR.mjSENS_FRAMELINACC, _SENSOR.mjSENS_FRAMEANGACC, _SENSOR.mjSENS_FRAMEXAXIS),
        *(_SENSOR.mjSENS_FRAMEYAXIS, _SENSOR.mjSENS_FRAMEZAXIS),
    )
)
"""Sensors that show where a body is and how it moves."""
_ROBOTS = 256
"""Answers that are kept, of robots and their bodies."""


class MountState(NamedTuple):
    """A body that may give, and the robot on it as the model has it, at the beginning of a step: moving about O.

    O is the origin of the body's frame.
    """

    coupling: Vector  #: angular momentum about O that unit speed of the joint gives, kg m2/s or kg m/s
    arm: Vector  #: force on the joint for each m/s2 of gravity
    momentum: Vector  #: angular momentum about O of all joints' speeds
    inertia: Symmetric  #: of the body and all that it carries, about O, kg m2
    first: Vector  #: mass times the way from O to the centre of mass, kg m
    gravity: Vector  #: m/s2


_ZERO = (0.0, 0.0, 0.0)
STILL = MountState(_ZERO, _ZERO, _ZERO, (1.0, 1.0, 1.0, 0.0, 0.0, 0.0), _ZERO, _ZERO)
"""One that carries nothing."""


class MountSensor(NamedTuple):
    """Three values of a sensor on a body that may give.

    Attributes:
        column: of the first in `sensordata`.
        axes: (3, 3) its axes in the world, one a row.
        arm: (3,) from the origin of the body's frame, m.
        accelerates: whether it is an accelerometer; else a gyroscope.
    """

    column: int
    axes: np.ndarray
    arm: np.ndarray
    accelerates: bool


@lru_cache(maxsize=_ROBOTS)
def mount_sites(robot: Robot) -> tuple[str, ...]:
    """Names of the bodies that the model welds to the world and whose giving could be told.

    They carry hinges and slides, and no sensors of motion but gyroscopes and accelerometers of their own.
    """
    names = robot.names("body")
    return tuple(names[b] for b in range(1, robot.model.nbody) if _may_give(robot, b))


@lru_cache(maxsize=_ROBOTS)
def carried_joints(robot: Robot, body: str) -> tuple[str, ...]:
    """Names of the joints that a body carries, its own left out."""
    return tuple(robot.names("joint")[j] for j in _carried(robot, robot.index("body", body)))


def mount_sensors(robot: Robot, body: str) -> tuple[MountSensor, ...]:
    """The gyroscopes and accelerometers on a body, or on what is welded to it."""
    model, data, index, found = robot.model, mujoco.MjData(robot.model), robot.index("body", body), []
    mujoco.mj_kinematics(model, data)
    for s in range(model.nsensor):
        kind, site = int(model.sensor_type[s]), int(model.sensor_objid[s])
        if kind in (int(_SENSOR.mjSENS_GYRO), int(_SENSOR.mjSENS_ACCELEROMETER)):
            at = int(model.site_bodyid[site])
            if at in robot.subtree(index) and not model.body_weldid[at]:
                axes, arm = data.site_xmat[site].reshape(3, 3).T.copy(), data.site_xpos[site] - data.xpos[index]
                accelerates = kind == int(_SENSOR.mjSENS_ACCELEROMETER)
                found.append(MountSensor(int(model.sensor_adr[s]), axes, arm, accelerates))
    return tuple(found)


def _carried(robot: Robot, body: int) -> list[int]:
    return [j for j in range(robot.model.njnt) if int(robot.model.jnt_bodyid[j]) in robot.subtree(body)]


def _may_give(robot: Robot, body: int) -> bool:
    model, joints = robot.model, _carried(robot, body)
    if model.body_weldid[body] != 0 or not joints or model.body_mass[body] <= 0.0 or model.body_mocapid[body] >= 0:
        return False
    return all(int(model.jnt_type[j]) in _SCALAR for j in joints) and not _shown_otherwise(robot, body)


def _shown_otherwise(robot: Robot, body: int) -> bool:
    """Whether sensors of motion show a body's giving that are not `mount_sensors`."""
    model, own = robot.model, {s.column for s in mount_sensors(robot, robot.names("body")[body])}
    kinds = zip(model.sensor_type.tolist(), model.sensor_adr.tolist(), strict=True)
    others = [s for s, (kind, column) in enumerate(kinds) if kind in _OF_MOTION and column not in own]
    carried = robot.subtree(body)
    return any(_body_of(model, s) in carried for s in others)


def _body_of(model: mujoco.MjModel, sensor: int) -> int:
    kind, index = int(model.sensor_objtype[sensor]), int(model.sensor_objid[sensor])
    of = {int(mujoco.mjtObj.mjOBJ_SITE): model.site_bodyid, int(mujoco.mjtObj.mjOBJ_GEOM): model.geom_bodyid}
    return int(of[kind][index]) if kind in of else index


def vector_product(a: Vector, b: Vector) -> Vector:
    """Vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def solved(m: Symmetric, b: Vector) -> Vector:
    """The x of M x = b, by cofactors."""
    xx, yy, zz, xy, xz, yz = m
    one = (yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy)
    other = (one[1], xx * zz - xz * xz, xy * xz - xx * yz)
    last = (one[2], other[2], xx * yy - xy * xy)
    size = xx * one[0] + xy * one[1] + xz * one[2]
    x, y, z = ((row[0] * b[0] + row[1] * b[1] + row[2] * b[2]) / size for row in (one, other, last))
    return x, y, z
