"""The state a replay starts from, estimated from the recording alone."""

from __future__ import annotations

import mujoco
import numpy as np

from estexp_jax.physics.recording import Recording
from estexp_jax.physics.robot import Robot
from estexp_jax.physics.segment import Path, Start

_HALF_WIDTH = 0.04
"""Samples this near (s) to the start count."""
_FEWEST = 7
"""... and at least so many."""
_CUBIC = 3
_Samples = tuple[np.ndarray | None, int | None]


def start_state(robot: Robot, recording: Recording, row: int, *, degree: int = 3) -> Start:
    """The state at a row.

    Joint positions and speeds come from a polynomial through the samples around the row, by least squares: of `qpos`
    columns, else of a joint position sensor. Measured speeds (`qvel` columns, joint velocity sensors) count before the
    polynomial's slope. What nothing measured is as in the home keyframe, at rest.

    Args:
        robot: the nominal robot with the recording's settings.
        recording: what was measured.
        row: where to start.
        degree: of the polynomial. Servos jolt: a parabola's slope was 4 times further off than a cubic's, also under
            noise of 2 mrad. How far another degree's state is from it tells how far both may be off.
    """
    model = robot.model
    qpos, qvel = robot.home(), np.zeros(model.nv)
    near = _near(recording.time, row)
    sensed: list[tuple[int, int, int]] = []
    for joint in range(model.njnt):
        if joint in robot.scalar_joints:
            place, speed = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
            samples, column = _position_samples(robot, recording, joint)
            position, slope = _local(recording, near, row, samples, degree)
            measured, _ = _local(recording, near, row, _speed_samples(robot, recording, joint)[0], degree)
            sensed += [(column, place, speed)] if column is not None else []
            qpos[place] = position if np.isfinite(position) else qpos[place]
            qvel[speed] = measured if np.isfinite(measured) else slope if np.isfinite(slope) else 0.0
    _measured_freely(model, recording, row, qpos, qvel)
    return Start(qpos, qvel, tuple(sensed))


def path_of(robot: Robot, recording: Recording) -> Path:
    """The state at every row, by the same means as `start_state`, of hinge and slide joints.

    Args:
        robot: the nominal robot with the recording's settings.
        recording: what was measured.
    """
    model, rows = robot.model, recording.rows
    qpos, qvel = np.tile(robot.home(), (rows, 1)), np.zeros((rows, model.nv))
    for joint in robot.scalar_joints:
        place, speed = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        samples = _position_samples(robot, recording, joint)[0]
        measured = _speed_samples(robot, recording, joint)[0]
        if samples is not None and np.isfinite(samples).sum() > _CUBIC:
            qpos[:, place], qvel[:, speed] = _smoothed(recording.time, samples)
        if measured is not None and np.isfinite(measured).sum() > _CUBIC:
            qvel[:, speed] = _smoothed(recording.time, measured)[0]
    return Path(recording.time, qpos, qvel)


def _smoothed(time: np.ndarray, samples: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Values and slopes (rows,) of cubics through the nearest samples of each row; gaps are bridged first."""
    good = np.isfinite(samples)
    whole = np.interp(time, time[good], samples[good])
    half = max(_FEWEST // 2, round(_HALF_WIDTH / float(np.median(np.diff(time)))))
    n = min(2 * half + 1, len(time))
    first = np.clip(np.arange(len(time)) - half, 0, len(time) - n)
    near = first[:, None] + np.arange(n)
    t = time[near] - time[:, None]
    reach = np.abs(t).max(axis=1, keepdims=True)
    basis = (t / reach)[..., None] ** np.arange(_CUBIC + 1)
    coefficients = np.linalg.pinv(basis) @ whole[near][..., None]
    return coefficients[:, 0, 0], coefficients[:, 1, 0] / reach[:, 0]


def _near(time: np.ndarray, row: int) -> np.ndarray:
    close = np.flatnonzero(np.abs(time - time[row]) <= _HALF_WIDTH)
    if len(close) >= _FEWEST:
        return close
    first = int(np.clip(row - _FEWEST // 2, 0, max(0, len(time) - _FEWEST)))
    return np.arange(first, min(len(time), first + _FEWEST))


def _local(
    recording: Recording, near: np.ndarray, row: int, samples: np.ndarray | None, degree: int
) -> tuple[float, float]:
    """Value and slope at the row; NaN where there are too few samples."""
    if samples is None:
        return np.nan, np.nan
    t, y = recording.time[near] - recording.time[row], samples[near]
    good = np.isfinite(y)
    if good.sum() < 3:
        return (float(y[good][0]), np.nan) if good.any() else (np.nan, np.nan)
    reach, terms = np.abs(t).max(), min(degree + 1, max(3, int(good.sum()) - 1))
    basis = np.vander(t[good] / reach, terms, increasing=True)
    coefficients = np.linalg.lstsq(basis, y[good], rcond=None)[0]
    return float(coefficients[0]), float(coefficients[1] / reach)


def _position_samples(robot: Robot, recording: Recording, joint: int) -> _Samples:
    place = int(robot.model.jnt_qposadr[joint])
    return _samples(robot, recording, joint, recording.qpos[:, place], mujoco.mjtSensor.mjSENS_JOINTPOS)


def _speed_samples(robot: Robot, recording: Recording, joint: int) -> _Samples:
    place = int(robot.model.jnt_dofadr[joint])
    return _samples(robot, recording, joint, recording.qvel[:, place], mujoco.mjtSensor.mjSENS_JOINTVEL)


def _samples(robot: Robot, recording: Recording, joint: int, column: np.ndarray, kind: mujoco.mjtSensor) -> _Samples:
    """Samples (rows,) of a joint: its own column, else a sensor of that kind on it, and that sensor's address."""
    if np.isfinite(column).any():
        return column, None
    model = robot.model
    for sensor in range(model.nsensor):
        if int(model.sensor_type[sensor]) == int(kind) and int(model.sensor_objid[sensor]) == joint:
            reading = recording.sensor[:, int(model.sensor_adr[sensor])]
            if np.isfinite(reading).any():
                return reading, int(model.sensor_adr[sensor])
    return None, None


def _measured_freely(model: mujoco.MjModel, recording: Recording, row: int, qpos: np.ndarray, qvel: np.ndarray) -> None:
    """Fill in the nearest measured coordinates of free and ball joints, in place."""
    for joint in range(model.njnt):
        kind = int(model.jnt_type[joint])
        if kind not in (int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)):
            continue
        nq, nv = (7, 6) if kind == int(mujoco.mjtJoint.mjJNT_FREE) else (4, 3)
        q, v = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
        for target, table, at, n in ((qpos, recording.qpos, q, nq), (qvel, recording.qvel, v, nv)):
            rows = np.flatnonzero(np.isfinite(table[:, at : at + n]).all(axis=1))
            if rows.size:
                target[at : at + n] = table[rows[np.argmin(np.abs(rows - row))], at : at + n]
        quaternion = slice(q + nq - 4, q + nq)
        qpos[quaternion] /= np.linalg.norm(qpos[quaternion])
