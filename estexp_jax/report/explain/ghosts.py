"""Nominal, real and explained robot in one scene, at moments of a test recording."""

from __future__ import annotations

from collections.abc import Mapping

import mujoco
import numpy as np

from estexp_jax.discovery.diagnosis import Diagnosis, Prediction
from estexp_jax.physics.model.robot import Robot
from estexp_jax.report.drawing.film import captioned, strip
from estexp_jax.report.drawing.gl import Shot, render_shots
from estexp_jax.report.drawing.robot_pictures import drawn, ground_covered, standing_view, tinted

_SIZE, _MOMENTS = (320, 262), 4
_REAL, _NOMINAL, _EXPLAINED = (0.35, 0.4, 0.45), (0.85, 0.35, 0.1), (0.1, 0.55, 0.85)
_SHARE = 0.15
"""Of the recording: moments are at least so far apart."""


def ghosts_of(diagnosis: Diagnosis) -> bytes | None:
    """A strip (JPEG) of a test recording where the nominal simulator misses the joints most.

    Grey: the robot as recorded; orange: as the nominal simulator predicts it; blue: as the explained one does. Joints
    that were not recorded stay at home, and a floating base is where it was recorded.

    Returns:
        None where no joint's position was recorded.

    Raises:
        NoGlError: nothing here can draw.
    """
    robot = diagnosis.case.robot
    tests = [(p, angles_of(robot, p)) for p in diagnosis.predictions if p.role == "test"]
    tests = [(p, angles) for p, angles in tests if angles]
    if not tests:
        return None
    prediction, angles = max(tests, key=lambda pair: _missed(*pair).max())
    moments = _moments(_missed(prediction, angles))
    if not len(moments):
        return None
    qpos = postures(diagnosis, prediction, angles, moments)
    centre, radius = ground_covered(robot, qpos.reshape(-1, robot.model.nq))
    rgba = np.stack([tinted(robot, _REAL, 1.0), tinted(robot, _NOMINAL, 0.45), tinted(robot, _EXPLAINED, 0.45)])
    shot = Shot(qpos, rgba, np.tile(centre, (len(moments), 1)), *standing_view(robot, radius))
    (pictures,) = render_shots(drawn(robot), [shot], width=_SIZE[0], height=_SIZE[1])
    told = [f"{prediction.recording}, {prediction.time[k]:.2f} s" for k in moments]
    return strip([[captioned(picture, text) for picture, text in zip(pictures, told, strict=True)]])


def angles_of(robot: Robot, prediction: Prediction) -> dict[int, int]:
    """Address in qpos of each joint whose position was recorded, to its channel."""
    model, columns = robot.model, robot.sensor_columns()
    found: dict[int, int] = {}
    for channel, name in enumerate(prediction.channels):
        if name.startswith("qpos."):
            joint = robot.index("joint", name.removeprefix("qpos."))
        else:
            sensor = int(np.searchsorted(model.sensor_adr, columns.index(name), side="right")) - 1
            if int(model.sensor_type[sensor]) != int(mujoco.mjtSensor.mjSENS_JOINTPOS):
                continue
            joint = int(model.sensor_objid[sensor])
        found.setdefault(int(model.jnt_qposadr[joint]), channel)
    return found


def postures(
    diagnosis: Diagnosis, prediction: Prediction, angles: Mapping[int, int], moments: np.ndarray
) -> np.ndarray:
    """Configurations (moments, 3, nq): as recorded, as nominally predicted, as explained."""
    case = diagnosis.case
    recording = next(r for r in case.recordings if r.name == prediction.recording)
    whole = recording.qpos[np.searchsorted(recording.time, prediction.time[moments])]
    known = np.isfinite(whole).all(axis=1, keepdims=True)
    base = np.where(known, whole, case.robot.home())
    qpos = np.repeat(base[:, None], 3, axis=1)
    for address, channel in angles.items():
        for layer, table in enumerate((prediction.recorded, prediction.nominal, prediction.explained)):
            qpos[:, layer, address] = table[moments, channel]
    return qpos


def _missed(prediction: Prediction, angles: Mapping[int, int]) -> np.ndarray:
    """Size (rows,) of the nominal simulator's error, of each joint's range; 0 where a joint has no sample."""
    chosen = list(angles.values())
    recorded, nominal = prediction.recorded[:, chosen], prediction.nominal[:, chosen]
    span = np.nanmax(recorded, axis=0) - np.nanmin(recorded, axis=0)
    size = np.linalg.norm((nominal - recorded) / np.where(span > 0.0, span, 1.0), axis=1)
    sound = np.isfinite(size) & np.isfinite(prediction.explained[:, chosen]).all(axis=1)
    return np.where(sound, size, 0.0)


def _moments(missed: np.ndarray) -> np.ndarray:
    """Rows of the largest errors, some way apart, in order."""
    left, found = missed.copy(), []
    apart = max(1, int(_SHARE * len(missed)))
    while len(found) < _MOMENTS and left.max() > 0.0:
        row = int(np.argmax(left))
        found.append(row)
        left[max(0, row - apart) : row + apart + 1] = 0.0
    return np.sort(np.array(found, dtype=int))
