"""Samples of the poses of free and ball joints: from their own columns, else from sensors of the body they move."""

from __future__ import annotations

from typing import NamedTuple

import mujoco
import numpy as np

from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_SENSOR, _OBJECT = mujoco.mjtSensor, mujoco.mjtObj
_FREE = int(mujoco.mjtJoint.mjJNT_FREE)


class PoseSamples(NamedTuple):
    """What was measured of a free or ball joint in each row; NaN where nothing was.

    Attributes:
        place, speed: (rows, 3) position and velocity of a free joint in world axes, m and m/s.
        turn: (rows, 4) quaternion.
        spin: (rows, 3) angular velocity in body axes, rad/s.
    """

    place: np.ndarray
    speed: np.ndarray
    turn: np.ndarray
    spin: np.ndarray


class _Frame(NamedTuple):
    """A frame on a body: its position and orientation (quaternion) in the body's own frame."""

    position: np.ndarray
    turn: np.ndarray


def pose_samples(robot: Robot, recording: Recording, joint: int) -> PoseSamples:
    """The measured pose of a free or ball joint.

    Of a ball joint, `ballquat` and `ballangvel` count; of a body that hangs from the world by the joint alone, sensors
    of the pose and the spin of any frame on it (`framepos`, `framequat`, `framelinvel` of the body, `gyro`).

    Args:
        robot: with the recording's settings.
        recording: of the robot.
        joint: index.
    """
    model = robot.model
    q, v = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    nothing = np.full((recording.rows, 3), np.nan)
    if int(model.jnt_type[joint]) != _FREE:
        turn = _first(recording.qpos[:, q : q + 4], _of_joint(robot, recording, joint, _SENSOR.mjSENS_BALLQUAT))
        spin = _first(recording.qvel[:, v : v + 3], _of_joint(robot, recording, joint, _SENSOR.mjSENS_BALLANGVEL))
        turn = _first(turn, _turn_of_body(robot, recording, joint))
        return PoseSamples(nothing, nothing, turn, _first(spin, _spin_of_body(robot, recording, joint)))
    turn = _first(recording.qpos[:, q + 3 : q + 7], _turn_of_body(robot, recording, joint))
    spin = _first(recording.qvel[:, v + 3 : v + 6], _spin_of_body(robot, recording, joint))
    place = _first(recording.qpos[:, q : q + 3], _place_of_body(robot, recording, joint, turn))
    speed = _first(recording.qvel[:, v : v + 3], _speed_of_body(robot, recording, joint))
    return PoseSamples(place, speed, turn, spin)


def _first(own: np.ndarray, other: np.ndarray | None) -> np.ndarray:
    """The first of two tables, or the second where the first has no sample."""
    return own if other is None or np.isfinite(own).any() else other


def _readings(robot: Robot, recording: Recording, sensor: int) -> np.ndarray | None:
    model = robot.model
    first = int(model.sensor_adr[sensor])
    found = recording.sensor[:, first : first + int(model.sensor_dim[sensor])]
    return found if np.isfinite(found).all(axis=1).any() and not model.sensor_cutoff[sensor] else None


def _of_joint(robot: Robot, recording: Recording, joint: int, kind: mujoco.mjtSensor) -> np.ndarray | None:
    model = robot.model
    for s in np.flatnonzero((model.sensor_type == int(kind)) & (model.sensor_objid == joint)).tolist():
        if (found := _readings(robot, recording, s)) is not None:
            return found
    return None


def _on_body(
    robot: Robot, recording: Recording, joint: int, kind: mujoco.mjtSensor
) -> tuple[np.ndarray, _Frame] | None:
    """Readings of a sensor of some frame on the joint's body, in world axes or its own, and the frame."""
    model, body = robot.model, int(robot.model.jnt_bodyid[joint])
    if int(model.body_jntnum[body]) != 1 or int(model.body_weldid[model.body_parentid[body]]) != 0:
        return None
    for s in np.flatnonzero(model.sensor_type == int(kind)).tolist():
        frame = _frame(model, s, body)
        if frame is None or int(model.sensor_reftype[s]) != int(_OBJECT.mjOBJ_UNKNOWN):
            continue
        if (found := _readings(robot, recording, s)) is not None:
            return found, frame
    return None


def _frame(model: mujoco.MjModel, sensor: int, body: int) -> _Frame | None:
    """The frame that a sensor reads, if it is on a body."""
    kind, i = _OBJECT(int(model.sensor_objtype[sensor])), int(model.sensor_objid[sensor])
    match kind:
        case _OBJECT.mjOBJ_XBODY if i == body:
            return _Frame(np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
        case _OBJECT.mjOBJ_BODY if i == body:
            return _Frame(model.body_ipos[i], model.body_iquat[i])
        case _OBJECT.mjOBJ_SITE if int(model.site_bodyid[i]) == body:
            return _Frame(model.site_pos[i], model.site_quat[i])
        case _OBJECT.mjOBJ_GEOM if int(model.geom_bodyid[i]) == body:
            return _Frame(model.geom_pos[i], model.geom_quat[i])
        case _:
            return None


def _turn_of_body(robot: Robot, recording: Recording, joint: int) -> np.ndarray | None:
    found = _on_body(robot, recording, joint, _SENSOR.mjSENS_FRAMEQUAT)
    if found is None:
        return None
    turn = _times(found[0], _conjugate(found[1].turn))
    if int(robot.model.jnt_type[joint]) == _FREE:
        return turn
    data = mujoco.MjData(robot.model)  # at qpos0, where a ball joint does not turn its body
    mujoco.mj_kinematics(robot.model, data)
    return _times(_conjugate(data.xquat[int(robot.model.jnt_bodyid[joint])]), turn)


def _spin_of_body(robot: Robot, recording: Recording, joint: int) -> np.ndarray | None:
    found = _on_body(robot, recording, joint, _SENSOR.mjSENS_GYRO)
    return None if found is None else _rotated(found[1].turn, found[0])


def _place_of_body(robot: Robot, recording: Recording, joint: int, turn: np.ndarray) -> np.ndarray | None:
    found = _on_body(robot, recording, joint, _SENSOR.mjSENS_FRAMEPOS)
    if found is None:
        return None
    place, frame = found
    return place - _rotated(turn, frame.position) if frame.position.any() else place


def _speed_of_body(robot: Robot, recording: Recording, joint: int) -> np.ndarray | None:
    found = _on_body(robot, recording, joint, _SENSOR.mjSENS_FRAMELINVEL)
    return None if found is None or found[1].position.any() else found[0]


def _conjugate(q: np.ndarray) -> np.ndarray:
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def _times(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Product (..., 4) of quaternions."""
    w, x, y, z = np.moveaxis(a, -1, 0)
    s, t, u, v = np.moveaxis(b, -1, 0)
    product = (
        w * s - x * t - y * u - z * v,
        w * t + x * s + y * v - z * u,
        w * u - x * v + y * s + z * t,
        w * v + x * u - y * t + z * s,
    )
    return np.stack(product, axis=-1)


def _rotated(turn: np.ndarray, vector: np.ndarray) -> np.ndarray:
    """Vectors (..., 3) rotated by quaternions (..., 4)."""
    pure = np.concatenate([np.zeros((*np.shape(vector)[:-1], 1)), vector], axis=-1)
    return _times(_times(turn, pure), _conjugate(turn))[..., 1:]
