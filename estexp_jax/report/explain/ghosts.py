"""Recorded, nominal and explained robot in one scene, at times of a test recording."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import mujoco
import numpy as np

from estexp_jax.physics.model.robot import Robot
from estexp_jax.report.channels import sensor_of
from estexp_jax.report.drawing.film import strip
from estexp_jax.report.drawing.gl import Shot, render_shots
from estexp_jax.report.drawing.robot_pictures import drawn, ground_covered, standing_view, tinted

if TYPE_CHECKING:
    from estexp_jax.discovery.diagnosis import Diagnosis, Prediction

_SIZE, _N_ROWS, _ACROSS = (420, 344), 4, 2
_REAL, _NOMINAL, _EXPLAINED = (0.35, 0.4, 0.45), (0.85, 0.35, 0.1), (0.1, 0.55, 0.85)
_SHARE = 0.15
"""Least spacing of the times, as a share of the recording."""


def ghosts_of(diagnosis: Diagnosis) -> tuple[bytes, str] | None:
    """Pictures (JPEG), two beside each other, of a test recording at the largest nominal errors of the joints.

    Grey: the robot as recorded; orange: as the nominal simulator predicts it; blue: as the explained one does. Joints
    that were not recorded stay at home, and a floating base is where it was recorded.

    Returns:
        The pictures, and where they are from; None if no joint's position was recorded.

    Raises:
        NoGlError: no renderer works here.
    """
    robot = diagnosis.case.robot
    tests = [(p, angles_of(robot, p)) for p in diagnosis.predictions if p.role == "test"]
    tests = [(p, angles) for p, angles in tests if angles]
    if not tests:
        return None
    prediction, angles = max(tests, key=lambda pair: _nominal_error(*pair).max())
    rows = _largest_errors(_nominal_error(prediction, angles))
    if not len(rows):
        return None
    qpos = postures(diagnosis, prediction, angles, rows)
    centre, radius = ground_covered(robot, qpos.reshape(-1, robot.model.nq))
    rgba = np.stack([tinted(robot, _REAL, 1.0), tinted(robot, _NOMINAL, 0.45), tinted(robot, _EXPLAINED, 0.45)])
    shot = Shot(qpos, rgba, np.tile(centre, (len(rows), 1)), *standing_view(robot, radius))
    (pictures,) = render_shots(drawn(robot), [shot], width=_SIZE[0], height=_SIZE[1])
    times = ", ".join(f"{prediction.time[k]:.2f}" for k in rows)
    even = list(pictures) + [np.full_like(pictures[0], 255)] * (len(pictures) % _ACROSS)
    lines = [even[k : k + _ACROSS] for k in range(0, len(even), _ACROSS)]
    return strip(lines), f"{prediction.recording}, line by line at {times} s."


def angles_of(robot: Robot, prediction: Prediction) -> dict[int, int]:
    """Channel of each recorded joint position, by the joint's address in qpos."""
    model = robot.model
    channels: dict[int, int] = {}
    for channel, name in enumerate(prediction.channels):
        if name.startswith("qpos."):
            joint = robot.index("joint", name.removeprefix("qpos."))
        else:
            sensor = sensor_of(robot, name)
            if int(model.sensor_type[sensor]) != int(mujoco.mjtSensor.mjSENS_JOINTPOS):
                continue
            joint = int(model.sensor_objid[sensor])
        channels.setdefault(int(model.jnt_qposadr[joint]), channel)
    return channels


def postures(diagnosis: Diagnosis, prediction: Prediction, angles: Mapping[int, int], rows: np.ndarray) -> np.ndarray:
    """Configurations (rows, 3, nq): recorded, nominal, explained."""
    case = diagnosis.case
    recording = next(r for r in case.recordings if r.name == prediction.recording)
    whole = recording.qpos[np.searchsorted(recording.time, prediction.time[rows])]
    known = np.isfinite(whole).all(axis=1, keepdims=True)
    base = np.where(known, whole, case.robot.home())
    qpos = np.repeat(base[:, None], 3, axis=1)
    for address, channel in angles.items():
        for layer, table in enumerate((prediction.recorded, prediction.nominal, prediction.explained)):
            qpos[:, layer, address] = table[rows, channel]
    return qpos


def _nominal_error(prediction: Prediction, angles: Mapping[int, int]) -> np.ndarray:
    """Norm (rows,) of the nominal errors relative to each joint's range; 0 where a joint has no sample."""
    chosen = list(angles.values())
    recorded, nominal = prediction.recorded[:, chosen], prediction.nominal[:, chosen]
    span = np.nanmax(recorded, axis=0) - np.nanmin(recorded, axis=0)
    size = np.linalg.norm((nominal - recorded) / np.where(span > 0.0, span, 1.0), axis=1)
    valid = np.isfinite(size) & np.isfinite(prediction.explained[:, chosen]).all(axis=1)
    return np.where(valid, size, 0.0)


def _largest_errors(errors: np.ndarray) -> np.ndarray:
    """Rows of the largest errors, with some spacing, in order."""
    remaining, rows = errors.copy(), []
    spacing = max(1, int(_SHARE * len(errors)))
    while len(rows) < _N_ROWS and remaining.max() > 0.0:
        row = int(np.argmax(remaining))
        rows.append(row)
        remaining[max(0, row - spacing) : row + spacing + 1] = 0.0
    return np.sort(np.array(rows, dtype=int))
