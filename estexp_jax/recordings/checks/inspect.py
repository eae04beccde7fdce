"""Judge a recording before anything is fitted to it: clock, gaps, saturation, excitation, units."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import mujoco
import numpy as np

from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.checks import excitation, faults, servo_faults, signals

GAP = 3.0
"""A step of the clock longer than this many median periods is a gap."""
MOST_GAPS = 20
"""Gaps that are listed; all are counted."""

# A joint counts as excited when its readings span more than this: about a degree, a millimetre, and a speed above the
# noise of a differentiated encoder.
_MOVED = {"angle": 0.02, "length": 0.001, "speed": 0.05}


def judge(robot: Robot, recording: Recording) -> dict[str, Any]:
    """What can be said of a recording without simulating it; plain numbers, ready for JSON.

    Returns:
        `file`, `role`, `rows`, `duration_s`;
        `clock`: `hz` and `period_s` (median), `jitter_s` (standard deviation of the period, gaps left out),
        `shortest_s`, `longest_s`, `steps` (their number), `gaps` (how many steps exceed `GAP` median periods),
        `gap_list` of `{time_s, length_s}`;
        `commands` by actuator: `low`, `high`, `saturated` (share of rows at or beyond ctrlrange, null without one),
        `enabled` (share of rows with the motor on), `changes` (rows whose command differs from the one before),
        `lag_s` (by how much a position servo's joint follows later, null where that does not show);
        `readings` by column: `samples`, `low`, `high`, null where there is none, and `step` (of its encoder, in the
        column's unit; null where it has none);
        `joints` by joint: `columns` that tell its motion, `span` (largest, in the column's unit), `excited` (null if
        nothing tells its motion), `tells` (by the names of `excitation.SUSPECTS`, whether its motion can tell them
        apart; empty if nothing tells its position);
        `faults`: what is wrong or looks so, each `{kind, name, sentence}`; `suspicions`: the same as sentences;
        `notes`: the reader's.
    """
    readings = _readings(robot, recording)
    joints = _joints(robot, recording, readings)
    clock, commands = _clock(recording.time), _commands(robot, recording, readings)
    found = list(dict.fromkeys(_faults(robot, recording, readings, {"clock": clock, "commands": commands})))
    found += [
        faults.Fault("still", n, "does not move in this recording") for n, j in joints.items() if j["excited"] is False
    ]
    found += [faults.Fault("empty", n, "never reads anything") for n, v in readings.items() if not np.isfinite(v).any()]
    return {
        "file": recording.name,
        "role": recording.role,
        "rows": recording.rows,
        "duration_s": recording.duration,
        "clock": clock,
        "commands": commands,
        "readings": {name: _range(values) for name, values in readings.items()},
        "joints": joints,
        "faults": [asdict(fault) for fault in found],
        "suspicions": [f"{fault.name}: {fault.sentence}" for fault in found],
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
        "shortest_s": float(steps.min()),
        "longest_s": float(steps.max()),
        "steps": len(steps),
        "gaps": len(gaps),
        "gap_list": [{"time_s": float(time[i]), "length_s": float(steps[i])} for i in gaps[:MOST_GAPS]],
    }


def _commands(robot: Robot, recording: Recording, readings: dict[str, np.ndarray]) -> dict[str, dict[str, Any]]:
    model, judged = robot.model, {}
    followers = {follower.actuator: follower.column for follower in _followers(robot, readings)}
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
            "lag_s": _lag(robot, recording, index, readings[followers[index]]) if index in followers else None,
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
    step = signals.encoder_step(samples) if len(samples) else 0.0
    return {"samples": len(samples), "low": low, "high": high, "step": step or None}


def _joints(robot: Robot, recording: Recording, readings: dict[str, np.ndarray]) -> dict[str, dict[str, Any]]:
    judged: dict[str, dict[str, Any]] = {}
    driven = {robot.joint_of_actuator(actuator): actuator for actuator in range(robot.model.nu)}
    for joint, name in enumerate(robot.names("joint")):
        kinds = {c: k for c, k in _columns_of_joint(robot, joint, readings).items() if np.isfinite(readings[c]).any()}
        spans = {column: float(np.ptp(readings[column][np.isfinite(readings[column])])) for column in kinds}
        judged[name] = {
            "columns": list(kinds),
            "span": max(spans.values(), default=None),
            "excited": any(spans[c] > _MOVED[kinds[c]] for c in kinds) if kinds else None,
            "tells": {},
        }
        position = next((column for column, kind in kinds.items() if kind != "speed"), None)
        if position is not None and np.isfinite(readings[position]).sum() > 2:
            rows = np.isfinite(readings[position])
            command = recording.ctrl[:, driven[joint]] if joint in driven else None
            motion = kinds[position], recording.time[rows], readings[position][rows]
            judged[name]["tells"] = excitation.sufficient_excitation(*motion, recording.time, command)
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


def _followers(robot: Robot, readings: dict[str, np.ndarray]) -> Iterator[servo_faults.Follower]:
    """Each position servo whose joint has a reading of its position."""
    for actuator, name in enumerate(robot.names("actuator")):
        joint = robot.joint_of_actuator(actuator)
        if joint is None or not servo_faults.is_position_servo(robot.model, actuator):
            continue
        for column, kind in _columns_of_joint(robot, joint, readings).items():
            if kind != "speed" and np.isfinite(readings[column]).any():
                yield servo_faults.Follower(actuator, name, column)
                break


def _lag(robot: Robot, recording: Recording, actuator: int, values: np.ndarray) -> float | None:
    pair = servo_faults.follows_commands(robot, recording, actuator, values)
    late, best, _ = signals.lag(*pair) if len(pair[0]) >= 20 else (0.0, 0.0, 0.0)
    return late if best > 0.8 else None


def _faults(robot: Robot, recording: Recording, readings: dict[str, np.ndarray], told: Any) -> Iterator[faults.Fault]:
    yield from faults.clock_faults(_evenest(recording, readings, told["clock"]))
    kinds: dict[str, str] = {}
    for joint in range(robot.model.njnt):
        columns = _columns_of_joint(robot, joint, readings)
        kinds |= columns
        hinge = robot.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
        for column, kind in columns.items():
            if hinge and kind == "angle":
                yield from faults.unit_faults(column, readings[column][np.isfinite(readings[column])])
        yield from _slopes(recording, columns, readings)
    for column, values in readings.items():
        rows = np.flatnonzero(np.isfinite(values))
        yield from faults.reading_faults(column, kinds.get(column, ""), recording.time[rows], values[rows], rows)
    for follower in _followers(robot, readings):
        yield from servo_faults.follower_faults(robot, recording, follower, readings[follower.column])
    for index, name in enumerate(robot.names("actuator")):
        yield from servo_faults.command_faults(robot, recording, index, name, told["commands"][name])


def _evenest(recording: Recording, readings: dict[str, np.ndarray], clock: dict[str, Any]) -> dict[str, Any]:
    """The clock of the rows or of the reading with most samples: merged logs have rows of several even clocks."""
    fullest = max(readings.values(), key=_samples, default=recording.time)
    own = recording.time[np.isfinite(fullest)]
    return min(clock, _clock(own) if len(own) > 2 else clock, key=_unevenness)


def _samples(values: np.ndarray) -> int:
    return int(np.isfinite(values).sum())


def _unevenness(clock: dict[str, Any]) -> float:
    return (clock["jitter_s"] / clock["period_s"]) + clock["gaps"] / clock["steps"]


def _slopes(recording: Recording, columns: dict[str, str], readings: dict[str, np.ndarray]) -> Iterator[faults.Fault]:
    """A joint's speed beside the slope of its position."""
    position = next((column for column, kind in columns.items() if kind != "speed"), None)
    rate = next((column for column, kind in columns.items() if kind == "speed"), None)
    if position is not None and rate is not None:
        rows = np.isfinite(readings[position]) & np.isfinite(readings[rate])
        pair = readings[position][rows], readings[rate][rows]
        yield from faults.slope_faults(position, rate, recording.time[rows], *pair)
