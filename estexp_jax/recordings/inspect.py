"""Judge a recording before anything is fitted to it: clock, gaps, saturation, excitation, units."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from estexp_jax.physics.recording import Recording
from estexp_jax.physics.robot import Robot

GAP = 3.0
"""A step of the clock longer than this many median periods is a gap."""
MOST_GAPS = 20
"""Gaps that are listed; all are counted."""
FULL_TURNS = 4.0 * math.pi
"""A hinge angle beyond this, rad, is more often degrees than two turns and more."""

# A joint counts as excited when its readings span more than this: about a degree, a millimetre, and a speed above the
# noise of a differentiated encoder.
_MOVED = {"angle": 0.02, "length": 0.001, "speed": 0.05}


def judge(robot: Robot, recording: Recording) -> dict[str, Any]:
    """What can be said of a recording without simulating it; plain numbers, ready for JSON.

    Returns:
        `file`, `role`, `rows`, `duration_s`;
        `clock`: `hz` and `period_s` (median), `jitter_s` (standard deviation of the period, gaps left out),
        `longest_s`, `gaps` (how many steps exceed `GAP` median periods), `gap_list` of `{time_s, length_s}`;
        `commands` by actuator: `low`, `high`, `saturated` (share of rows at or beyond ctrlrange, null without one),
        `enabled` (share of rows with the motor on), `changes` (rows whose command differs from the one before);
        `readings` by column: `samples`, `low`, `high`, null where there is none;
        `joints` by joint: `columns` that tell its motion, `span` (largest, in the column's unit), `excited` (null if
        nothing tells its motion);
        `suspicions`: sentences about units and sense; `notes`: the reader's.
    """
    readings = _readings(robot, recording)
    joints = _joints(robot, readings)
    return {
        "file": recording.name,
        "role": recording.role,
        "rows": recording.rows,
        "duration_s": recording.duration,
        "clock": _clock(recording.time),
        "commands": _commands(robot, recording),
        "readings": {name: _range(values) for name, values in readings.items()},
        "joints": joints,
        "suspicions": _suspicions(robot, recording, readings, joints),
        "notes": list(recording.notes),
    }


def _clock(time: np.ndarray) -> dict[str, Any]:
    steps = np.diff(time)
    period = float(np.median(steps))
    gaps = np.flatnonzero(steps > GAP * period)
    return {
        "hz": 1.0 / period,
        "period_s": period,
        "jitter_s": float(np.std(steps[steps <= GAP * period])),
        "longest_s": float(steps.max()),
        "gaps": len(gaps),
        "gap_list": [{"time_s": float(time[i]), "length_s": float(steps[i])} for i in gaps[:MOST_GAPS]],
    }


def _commands(robot: Robot, recording: Recording) -> dict[str, dict[str, Any]]:
    model, judged = robot.model, {}
    for index, name in enumerate(robot.names("actuator")):
        values = recording.ctrl[:, index]
        saturated = None
        if model.actuator_ctrllimited[index]:
            low, high = model.actuator_ctrlrange[index]
            saturated = float(np.mean((values <= low) | (values >= high)))
        judged[name] = {
            "low": float(values.min()),
            "high": float(values.max()),
            "saturated": saturated,
            "enabled": float(recording.enable[:, index].mean()),
            "changes": int(np.count_nonzero(np.diff(values))),
        }
    return judged


def _readings(robot: Robot, recording: Recording) -> dict[str, np.ndarray]:
    """Sensor columns all, state columns only where something measured them; by our column names."""
    readings = {f"sensor.{name}": recording.sensor[:, i] for i, name in enumerate(robot.sensor_columns())}
    model = robot.model
    for kind, table, addresses in (
        ("qpos", recording.qpos, model.jnt_qposadr),
        ("qvel", recording.qvel, model.jnt_dofadr),
    ):
        ends = [*addresses[1:], table.shape[1]]
        for name, start, end in zip(robot.names("joint"), addresses, ends, strict=False):
            for column in range(start, end):
                if np.isfinite(table[:, column]).any():
                    suffix = f".{column - start}" if end - start > 1 else ""
                    readings[f"{kind}.{name}{suffix}"] = table[:, column]
    return readings


def _range(values: np.ndarray) -> dict[str, Any]:
    samples = values[np.isfinite(values)]
    low, high = (float(samples.min()), float(samples.max())) if len(samples) else (None, None)
    return {"samples": len(samples), "low": low, "high": high}


def _joints(robot: Robot, readings: dict[str, np.ndarray]) -> dict[str, dict[str, Any]]:
    judged: dict[str, dict[str, Any]] = {}
    for joint, name in enumerate(robot.names("joint")):
        kinds = {c: k for c, k in _columns_of_joint(robot, joint, readings).items() if np.isfinite(readings[c]).any()}
        spans = {column: float(np.ptp(readings[column][np.isfinite(readings[column])])) for column in kinds}
        judged[name] = {
            "columns": list(kinds),
            "span": max(spans.values(), default=None),
            "excited": any(spans[c] > _MOVED[kinds[c]] for c in kinds) if kinds else None,
        }
    return judged


def _columns_of_joint(robot: Robot, joint: int, readings: dict[str, np.ndarray]) -> dict[str, str]:
    """Columns that tell a joint's motion, each with what it measures."""
    model, name = robot.model, robot.names("joint")[joint]
    slides = model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_SLIDE
    columns: dict[str, str] = {}
    for sensor, kind in enumerate(model.sensor_type):
        if model.sensor_objid[sensor] != joint:
            continue
        if kind == mujoco.mjtSensor.mjSENS_JOINTPOS:
            columns[f"sensor.{robot.names('sensor')[sensor]}"] = "length" if slides else "angle"
        elif kind == mujoco.mjtSensor.mjSENS_JOINTVEL:
            columns[f"sensor.{robot.names('sensor')[sensor]}"] = "speed"
    for column in readings:
        kind, _, rest = column.partition(".")
        if rest == name or (rest.startswith(f"{name}.") and rest.removeprefix(f"{name}.").isdigit()):
            columns |= {"qpos": {column: "length" if slides else "angle"}, "qvel": {column: "speed"}}.get(kind, {})
    return columns


def _suspicions(robot: Robot, recording: Recording, readings: dict[str, np.ndarray], joints: Any) -> list[str]:
    found: list[str] = []
    period = float(np.median(np.diff(recording.time)))
    if period >= 0.5 or period < 1e-6:
        found.append(f"time: rows are {period:.3g} s apart; is the clock in another unit than seconds?")
    hinges = np.flatnonzero(robot.model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE).tolist()
    for joint in hinges:
        for column, kind in _columns_of_joint(robot, joint, readings).items():
            samples = readings[column][np.isfinite(readings[column])]
            if kind == "angle" and len(samples) and np.abs(samples).max() > FULL_TURNS:
                found.append(f"{column}: reaches {np.abs(samples).max():.4g} rad; is it in degrees?")
    for actuator, name in enumerate(robot.names("actuator")):
        if robot.joint_of_actuator(actuator) in hinges and _is_position_servo(robot.model, actuator):
            most = float(np.abs(recording.ctrl[:, actuator] * robot.model.actuator_gear[actuator, 0]).max())
            if most > FULL_TURNS:
                found.append(f"ctrl.{name}: commands up to {most:.4g} rad; is it in degrees?")
    found += [f"{name}: does not move in this recording" for name, joint in joints.items() if joint["excited"] is False]
    found += [f"{name}: never reads anything" for name, values in readings.items() if not np.isfinite(values).any()]
    return found


def _is_position_servo(model: mujoco.MjModel, actuator: int) -> bool:
    direct = model.actuator_dyntype[actuator] != mujoco.mjtDyn.mjDYN_INTEGRATOR
    return bool(direct and model.actuator_biasprm[actuator, 1] != 0.0)
