"""Initial states of simulations, estimated from the recording alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from estexp_jax.estimation.pose_samples import PoseSamples, pose_samples
from estexp_jax.estimation.smoother import SmoothedTrack, smooth
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.reading_noise import noise_std_of
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, StateEstimate

_Source = tuple[np.ndarray | None, int | None]
_FREE, _BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)


@final
@dataclass(frozen=True, eq=False)
class EstimatedMotion:
    """The robot's state at every row of a recording.

    Attributes:
        trajectory: positions and speeds; coordinates that are not measured are at home at rest.
        covariance: (rows, nv, 2, 2) of each degree of freedom's position (in the tangent space) and speed; 0 where it
            is not measured.
        sensed: as in `InitialState`.
    """

    trajectory: StateEstimate
    covariance: np.ndarray
    sensed: tuple[tuple[int, int, int], ...]

    def state_at(self, row: int) -> InitialState:
        """The initial state of a window that begins at a row."""
        return InitialState(
            self.trajectory.qpos[row].copy(), self.trajectory.qvel[row].copy(), self.sensed, self.covariance[row]
        )


def estimate_motion(robot: Robot, recording: Recording) -> EstimatedMotion:
    """Estimate the state at every row.

    Joint positions are read from `qpos` columns, else from joint position sensors; speeds from `qvel` columns, else
    from joint velocity sensors, if there are any. A smoother combines both. Free and ball joints are read as
    `pose_samples` says.

    Args:
        robot: the nominal robot with the recording's settings.
        recording: of the robot.
    """
    model, rows = robot.model, recording.rows
    path = StateEstimate(recording.time, np.tile(robot.home(), (rows, 1)), np.zeros((rows, model.nv)))
    found = EstimatedMotion(path, np.zeros((rows, model.nv, 2, 2)), _scalar_joints(robot, recording, path))
    _read_scalar(robot, recording, found)
    for joint in range(model.njnt):
        if int(model.jnt_type[joint]) in (_FREE, _BALL):
            _read_freely(robot, joint, recording, found)
    return found


def _scalar_joints(robot: Robot, recording: Recording, path: StateEstimate) -> tuple[tuple[int, int, int], ...]:
    """`InitialState.sensed` of a recording."""
    model = robot.model
    found = []
    for joint in robot.scalar_joints:
        column = _position_samples(robot, recording, joint)[1]
        if column is not None:
            found.append((column, int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])))
    return tuple(found)


def _read_scalar(robot: Robot, recording: Recording, found: EstimatedMotion) -> None:
    """Write the states of hinge and slide joints, in place."""
    model, nothing = robot.model, np.full(recording.rows, np.nan)
    places, speeds, samples, derivatives = [], [], [], []
    for joint in robot.scalar_joints:
        position, speed = _position_samples(robot, recording, joint)[0], _speed_samples(robot, recording, joint)[0]
        dof = int(model.jnt_dofadr[joint])
        if position is not None:
            places.append(int(model.jnt_qposadr[joint]))
            speeds.append(dof)
            samples.append(position)
            derivatives.append(nothing if speed is None else speed)
        elif speed is not None:
            lone = _track(recording, speed[:, None], nothing[:, None])
            found.trajectory.qvel[:, dof] = lone.value[:, 0]
            found.covariance[:, dof, 1, 1] = lone.covariance[:, 0, 0, 0]
    if places:
        track = _track(recording, np.stack(samples, axis=1), np.stack(derivatives, axis=1))
        found.trajectory.qpos[:, places], found.trajectory.qvel[:, speeds] = track.value, track.slope
        found.covariance[:, speeds] = track.covariance


def _track(recording: Recording, samples: np.ndarray, derivatives: np.ndarray) -> SmoothedTrack:
    noise, slope_noise = (
        np.array([noise_std_of(recording.time, c) for c in table.T]) for table in (samples, derivatives)
    )
    return smooth(recording.time, samples, np.nan_to_num(noise), derivatives, slope_noise)


def _position_samples(robot: Robot, recording: Recording, joint: int) -> _Source:
    place = int(robot.model.jnt_qposadr[joint])
    return _samples(robot, recording, joint, recording.qpos[:, place], mujoco.mjtSensor.mjSENS_JOINTPOS)


def _speed_samples(robot: Robot, recording: Recording, joint: int) -> _Source:
    place = int(robot.model.jnt_dofadr[joint])
    return _samples(robot, recording, joint, recording.qvel[:, place], mujoco.mjtSensor.mjSENS_JOINTVEL)


def _samples(robot: Robot, recording: Recording, joint: int, column: np.ndarray, kind: mujoco.mjtSensor) -> _Source:
    """Samples (rows,) of a joint from its own column or else from a sensor of that kind, and the sensor's address."""
    if np.isfinite(column).any():
        return column, None
    model = robot.model
    for sensor in range(model.nsensor):
        if int(model.sensor_type[sensor]) == int(kind) and int(model.sensor_objid[sensor]) == joint:
            reading = recording.sensor[:, int(model.sensor_adr[sensor])]
            if np.isfinite(reading).any():
                return reading, int(model.sensor_adr[sensor])
    return None, None


def _read_freely(robot: Robot, joint: int, recording: Recording, found: EstimatedMotion) -> None:
    """Write the states of a free or ball joint, in place."""
    model, samples = robot.model, pose_samples(robot, recording, joint)
    q, v = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    if int(model.jnt_type[joint]) == _FREE:
        _read_point(recording, slice(q, q + 3), slice(v, v + 3), samples, found)
        q, v = q + 3, v + 3
    _read_turn(recording, slice(q, q + 4), slice(v, v + 3), samples, found)


def _read_point(
    recording: Recording, place: slice, speed: slice, measured: PoseSamples, found: EstimatedMotion
) -> None:
    """A free joint's position and the speed in world axes."""
    samples, derivatives = measured.place, measured.speed
    if np.isfinite(samples).any(axis=0).all():
        track = _track(recording, samples, derivatives)
        found.trajectory.qpos[:, place], found.trajectory.qvel[:, speed] = track.value, track.slope
        found.covariance[:, speed] = track.covariance


def _read_turn(recording: Recording, place: slice, speed: slice, measured: PoseSamples, found: EstimatedMotion) -> None:
    """A quaternion, and the angular velocity in body axes: measured, else from the quaternion's derivative."""
    samples, spin = measured.turn, measured.spin
    nothing = np.full_like(samples, np.nan)
    if np.isfinite(samples).any(axis=0).all():
        track = _track(recording, _steady(samples), nothing)
        size = np.linalg.norm(track.value, axis=1, keepdims=True)
        unit = track.value / size
        found.trajectory.qpos[:, place] = unit
        found.trajectory.qvel[:, speed] = 2.0 * _in_body(unit, track.slope / size)
        found.covariance[:, speed] = 4.0 * track.covariance.mean(axis=1, keepdims=True)
    if np.isfinite(spin).any(axis=0).all():
        track = _track(recording, spin, nothing[:, :3])
        found.trajectory.qvel[:, speed] = track.value
        found.covariance[:, speed, 0, 1] = found.covariance[:, speed, 1, 0] = 0.0
        found.covariance[:, speed, 1, 1] = track.covariance[..., 0, 0]


def _steady(quaternion: np.ndarray) -> np.ndarray:
    """The same rotations (rows, 4) without sign changes between rows."""
    good = np.isfinite(quaternion).all(axis=1)
    known = quaternion[good]
    jumps = np.sum(known[1:] * known[:-1], axis=1) < 0.0
    found = np.full_like(quaternion, np.nan)
    found[good] = known * np.concatenate([[1.0], np.where(np.cumsum(jumps) % 2 == 1, -1.0, 1.0)])[:, None]
    return found


def _in_body(quaternion: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Vector part (rows, 3) of conj(quaternion) * slope."""
    w, x, y, z = quaternion.T
    a, b, c, d = slope.T
    return np.stack(
        [w * b - x * a - y * d + z * c, w * c + x * d - y * a - z * b, w * d - x * c + y * b - z * a], axis=1
    )
