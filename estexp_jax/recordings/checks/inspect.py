"""Check a recording before anything is fitted to it: clock, gaps, saturation, excitation, units."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import asdict
from typing import Any

import mujoco
import numpy as np

from estexp_jax.physics.model.actuators import actuator_of_input
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.checks import clock_agreement, excitation, faults, model_faults, servo_faults, signals
from estexp_jax.recordings.checks.zero_faults import limit_faults

GAP = 3.0
"""A clock step longer than this many median periods is a gap."""
MOST_GAPS = 20
"""How many gaps are listed; all are counted."""
CLOCK_KINDS = frozenset({"time_unit", "ahead", "clock_drift"})
"""Faults of clocks that would be taken for physics."""

# A joint counts as excited when its readings span more than this: about a degree, a millimetre, and a speed above the
# noise of a differentiated encoder.
_MOVED = {"angle": 0.02, "length": 0.001, "speed": 0.05}


def judge(robot: Robot, recording: Recording, *, replayed: bool = True, beside_physics: bool = True) -> dict[str, Any]:
    """The properties and faults of a recording, as plain JSON values.

    Args:
        robot: with the recording's settings applied.
        recording: the log.
        replayed: also replay pieces of it with the model, and look for faults of logging.
        beside_physics: among these also for such as physics may hide, which takes seconds.

    Returns:
        `file`, `role`, `rows`, `duration_s`;
        `clock`: `hz` and `period_s` (median), `jitter_s` (standard deviation of the period, gaps left out),
        `shortest_s`, `longest_s`, `steps` (their number), `gaps` (how many steps exceed `GAP` median periods),
        `gap_list` of `{time_s, length_s}`;
        `commands` by command (`<actuator>`, with `.0 .1 ...` where it has several inputs): `low`, `high`, `saturated`
        (share of rows at or beyond ctrlrange, null without one),
        `enabled` (share of rows with the motor on), `changes` (rows whose command differs from the one before),
        `lag_s` (delay of a position servo's joint behind its command, null where it cannot be measured);
        `readings` by column: `samples`, `low` and `high` (null without samples), and `step` (encoder resolution in the
        column's unit, null if none is found);
        `joints` by joint: `columns` that measure its motion, `span` (largest, in the column's unit), `excited` (null
        if its motion is not measured), `tells` (for each name in `excitation.SUSPECTS`, whether the motion can
        distinguish that group; empty if its position is not measured);
        `faults`: each `{kind, name, sentence}`; `suspicions`: the same as sentences; `notes`: of the reader.
    """
    readings = _readings(robot, recording)
    joints = _joints(robot, recording, readings)
    clock, commands = _clock(recording.time), _commands(robot, recording, readings)
    found_faults = list(dict.fromkeys(_faults(robot, recording, readings, {"clock": clock, "commands": commands})))
    found_faults += [
        faults.Fault("still", n, "does not move in this recording") for n, j in joints.items() if j["excited"] is False
    ]
    silent = [name for name, values in readings.items() if not np.isfinite(values).any()]
    found_faults += [faults.Fault("empty", name, "never reads anything") for name in silent]
    logging = [*model_faults.model_faults(robot, recording, beside_physics=beside_physics)] if replayed else []
    assumed = model_faults.assumed(robot, recording) if replayed and not logging else []
    found_faults += logging
    return {
        "file": recording.name,
        "role": recording.role,
        "rows": recording.rows,
        "duration_s": recording.duration,
        "clock": clock,
        "commands": commands,
        "readings": {name: _range(values) for name, values in readings.items()},
        "joints": joints,
        "faults": [asdict(fault) for fault in found_faults],
        "suspicions": [f"{fault.name}: {fault.sentence}" for fault in found_faults],
        "notes": [*recording.notes, *assumed],
    }


def _clock(time: np.ndarray) -> dict[str, Any]:
    steps = np.diff(time)
    period = float(np.median(steps))
    gap_rows = np.flatnonzero(steps > GAP * period)
    return {
        "hz": 1.0 / period,
        "period_s": period,
        "jitter_s": float(np.std(steps[steps <= GAP * period])),
        "shortest_s": float(steps.min()),
        "longest_s": float(steps.max()),
        "steps": len(steps),
        "gaps": len(gap_rows),
        "gap_list": [{"time_s": float(time[i]), "length_s": float(steps[i])} for i in gap_rows[:MOST_GAPS]],
    }


def _commands(robot: Robot, recording: Recording, readings: dict[str, np.ndarray]) -> dict[str, dict[str, Any]]:
    model, summaries = robot.model, {}
    followers = {follower.actuator: follower.column for follower in _position_servos(robot, readings)}
    owners = actuator_of_input(model)
    for index, name in enumerate(robot.command_columns()):
        values, owner = recording.ctrl[:, index], int(owners[index])
        follows = owner in followers and index == servo_faults.target_input(model, owner)
        saturated = None
        if model.actuator_ctrllimited[index]:
            low, high = model.actuator_ctrlrange[index]
            saturated = float(np.mean((values <= low) | (values >= high)))
        summaries[name] = {
            "low": float(values.min()),
            "high": float(values.max()),
            "saturated": saturated,
            "enabled": float(recording.enable[:, owner].mean()),
            "changes": int(np.count_nonzero(np.diff(values))),
            "lag_s": _lag(robot, recording, owner, readings[followers[owner]]) if follows else None,
        }
    return summaries


def _readings(robot: Robot, recording: Recording) -> dict[str, np.ndarray]:
    """All sensor columns and the measured state columns, by our column names."""
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
    summaries: dict[str, dict[str, Any]] = {}
    motors = enumerate(actuator_of_input(robot.model).tolist())
    driven = {robot.joint_of_actuator(actuator): index for index, actuator in motors}
    for joint, name in enumerate(robot.names("joint")):
        kinds = {c: k for c, k in _columns_of_joint(robot, joint, readings).items() if np.isfinite(readings[c]).any()}
        spans = {column: float(np.ptp(readings[column][np.isfinite(readings[column])])) for column in kinds}
        summaries[name] = {
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
            summaries[name]["tells"] = excitation.sufficient_excitation(*motion, recording.time, command)
    return summaries


def _columns_of_joint(robot: Robot, joint: int, readings: dict[str, np.ndarray]) -> dict[str, str]:
    """Columns that measure a joint's motion, each with its kind."""
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


def _position_servos(robot: Robot, readings: dict[str, np.ndarray]) -> Iterator[servo_faults.Follower]:
    """Each position servo whose joint position is measured."""
    for actuator, name in enumerate(robot.names("actuator")):
        joint = robot.joint_of_actuator(actuator)
        if joint is None or servo_faults.target_input(robot.model, actuator) is None:
            continue
        for column, kind in _columns_of_joint(robot, joint, readings).items():
            if kind != "speed" and np.isfinite(readings[column]).any():
                yield servo_faults.Follower(actuator, name, column)
                break


def _lag(robot: Robot, recording: Recording, actuator: int, values: np.ndarray) -> float | None:
    pair = servo_faults.follows_commands(robot, recording, actuator, values)
    lag_s, correlation, _ = signals.lag(*pair) if len(pair[0]) >= 20 else (0.0, 0.0, 0.0)
    return lag_s if correlation > 0.8 else None


def _faults(
    robot: Robot, recording: Recording, readings: dict[str, np.ndarray], summaries: Any
) -> Iterator[faults.Fault]:
    yield from faults.clock_faults(_most_even_clock(recording, readings, summaries["clock"]), recording.time)
    kinds: dict[str, str] = {}
    for joint in range(robot.model.njnt):
        columns = _columns_of_joint(robot, joint, readings)
        kinds |= columns
        hinge = robot.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
        for column, kind in columns.items():
            samples = readings[column][np.isfinite(readings[column])]
            if hinge and kind == "angle":
                yield from faults.unit_faults(column, samples)
            if joint in robot.scalar_joints and kind != "speed":
                yield from limit_faults(robot, joint, column, samples)
        yield from faults.speed_faults(recording.time, columns, readings)
    for column, values in readings.items():
        rows = np.flatnonzero(np.isfinite(values))
        yield from faults.reading_faults(column, kinds.get(column, ""), recording.time[rows], values[rows], rows)
    for follower in _position_servos(robot, readings):
        values = readings[follower.column]
        yield from servo_faults.follower_faults(robot, recording, follower, values)
        moved = servo_faults.follows_commands(robot, recording, follower.actuator, values)
        if len(moved[0]) >= 20:
            yield from clock_agreement.agreement_faults(follower.column, *moved)
    for index, name in enumerate(robot.command_columns()):
        yield from servo_faults.command_faults(robot, recording, index, name, summaries["commands"][name])


def _most_even_clock(recording: Recording, readings: dict[str, np.ndarray], clock: dict[str, Any]) -> dict[str, Any]:
    """The more even of two clocks: that of the rows, or of the reading with most samples.

    Merged logs have rows from several clocks, each of which may be even.
    """
    densest = max(readings.values(), key=_n_samples, default=recording.time)
    own = recording.time[np.isfinite(densest)]
    return min(clock, _clock(own) if len(own) > 2 else clock, key=_irregularity)


def _n_samples(values: np.ndarray) -> int:
    return int(np.isfinite(values).sum())


def _irregularity(clock: dict[str, Any]) -> float:
    return (clock["jitter_s"] / clock["period_s"]) + clock["gaps"] / clock["steps"]
