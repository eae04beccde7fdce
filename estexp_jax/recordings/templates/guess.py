"""Guess which of a log's columns are ours: by name, or by order where no name says anything, or not at all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import mujoco
import numpy as np

from estexp_jax.physics.model.actuators import POSITION, VELOCITY, declared_inputs, inputs_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.bind import column_names
from estexp_jax.recordings.templates.matching import (
    BY_NAME,
    BY_ORDER,
    ColumnGroup,
    Guess,
    in_order,
    matched_by_name,
    one_list,
)
from estexp_jax.recordings.templates.names import NamedColumn, Quantity, owner_of, owners

_ONLY = "a guess, the only one: check this"
_READINGS: Mapping[mujoco.mjtSensor, Quantity] = {
    mujoco.mjtSensor.mjSENS_JOINTPOS: "position",
    mujoco.mjtSensor.mjSENS_JOINTVEL: "velocity",
    mujoco.mjtSensor.mjSENS_JOINTACTFRC: "effort",
}
_INPUTS: Mapping[int, Quantity] = {POSITION: "position", VELOCITY: "velocity"}


def guesses(robot: Robot, columns: Sequence[NamedColumn]) -> dict[str, Guess]:
    """Which of a log's columns may be ours: `ctrl.Elbow` is `command_Elbow`.

    Names are matched as whole words at the end of a column's name, the longest first. Columns are taken in their order
    only where no column of their kind bears the name of any joint.

    Args:
        robot: whose columns are wanted.
        columns: the log's.

    Returns:
        Our column to the guess. Ours that the log has under our own name are left out, and so are those that no column
        resembles.
    """
    own = {column.name for column in columns}
    free = [column for column in columns if column.name not in column_names(robot)]
    known, found = owners(_known_names(robot)), _clock(free)
    free = [column for column in free if not (column.is_aside or column.is_clock)]
    by_order: dict[str, list[tuple[str, NamedColumn]]] = {}
    for kind, group in _groups(robot, free).items():
        matched = matched_by_name(group, known)
        columns = one_list(group.columns, len(group.joints))
        if matched is None and len(columns) == len(group.joints) and not group.joints.keys() & found.keys():
            by_order[kind] = in_order(ColumnGroup(group.joints, columns), known)
            why = _ONLY if len(columns) == 1 else BY_ORDER
            matched = {ours: Guess(column, why) for ours, column in by_order[kind]}
        matched = matched or {}
        found |= {ours: each for ours, each in matched.items() if ours not in found}
    found |= _contradicting(by_order)
    return {ours: each for ours, each in found.items() if ours not in own}


def _known_names(robot: Robot) -> dict[str, list[str]]:
    """The names by which each joint is known, and each actuator that drives none."""
    names = {joint: [joint] for joint in robot.names("joint")}
    for actuator, joint in _actuators(robot).items():
        names.setdefault(joint, []).append(actuator)
    for kind in _READINGS:
        for sensor, joint in _sensors(robot, kind).items():
            names[joint].append(sensor)
    return names


def _actuators(robot: Robot) -> dict[str, str]:
    """Each actuator and the joint it drives, or itself."""
    pairs = ((name, robot.joint_of_actuator(index)) for index, name in enumerate(robot.names("actuator")))
    return {name: name if joint is None else robot.names("joint")[joint] for name, joint in pairs}


def _sensors(robot: Robot, kind: mujoco.mjtSensor) -> dict[str, str]:
    """Each sensor of a kind and its joint."""
    found = np.flatnonzero(robot.model.sensor_type == kind).tolist()
    return {robot.names("sensor")[i]: robot.names("joint")[robot.model.sensor_objid[i]] for i in found}


def _commands(robot: Robot) -> dict[str, tuple[str, Quantity]]:
    """Each command that is one number: the joint it goes to, or its actuator, and what is commanded there.

    A servo is commanded a position or a velocity, other actuators an effort; orientations are not guessed.
    """
    model, found = robot.model, {}
    joints, columns = list(_actuators(robot).values()), robot.command_columns()
    for actuator, joint in enumerate(joints):
        inputs, bias = inputs_of(model, actuator), model.actuator_biasprm[actuator]
        declared = [_INPUTS.get(kind, "effort") for kind in declared_inputs(model, actuator)]
        if not declared and len(inputs) == 1:
            servo = model.actuator_biastype[actuator] == mujoco.mjtBias.mjBIAS_AFFINE
            declared = ["position" if servo and bias[1] else "velocity" if servo and bias[2] else "effort"]
        found |= {columns[k]: (joint, quantity) for k, quantity in zip(inputs, declared, strict=False)}
    return found


def _groups(robot: Robot, free: Sequence[NamedColumn]) -> dict[str, ColumnGroup]:
    """Elements and the columns that may be theirs, by kind and quantity; a later one takes what an earlier left."""
    wanted = _commands(robot)
    commands = [column for column in free if column.is_command]
    groups: dict[str, ColumnGroup] = {}
    for quantity in dict.fromkeys(quantity for _, quantity in wanted.values()):
        ours = {f"ctrl.{name}": joint for name, (joint, asked) in wanted.items() if asked == quantity}
        groups[f"ctrl {quantity}"] = ColumnGroup(ours, [c for c in commands if c.quantity == quantity])
        groups[f"ctrl, any {quantity}"] = ColumnGroup(ours, [c for c in commands if not c.quantity])
    switches = {f"enable.{name}": joint for name, joint in _actuators(robot).items()}
    groups["enable"] = ColumnGroup(switches, [c for c in free if c.is_switch])
    readings = [column for column in free if not column.is_command and not column.is_switch]
    for kind, quantity in _READINGS.items():
        ours = {f"sensor.{name}": joint for name, joint in _sensors(robot, kind).items()}
        groups[f"sensor {quantity}"] = ColumnGroup(ours, [c for c in readings if c.quantity == quantity])
        if quantity == "position":
            groups["sensor"] = ColumnGroup(
                ours, [c for c in readings if not c.quantity and owner_of(c, owners(_known_names(robot)))]
            )
    return {kind: group for kind, group in groups.items() if group.joints}


def _contradicting(by_order: Mapping[str, Sequence[tuple[str, NamedColumn]]]) -> dict[str, Guess]:
    """Guesses by order that contradict each other: the log has the same names in two orders."""
    found: dict[str, Guess] = {}
    entries = list(by_order.values())
    for k, one in enumerate(entries):
        for two in entries[k + 1 :]:
            first, second = ([column.owner for _, column in each] for each in (one, two))
            if first != second and sorted(first) == sorted(second) and len(set(first)) > 1:
                why = "open: the log has its joints in another order here than there"
                found |= {ours: Guess(None, f"{why} ({column.name}?)") for ours, column in (*one, *two)}
    return found


def _clock(free: Sequence[NamedColumn]) -> dict[str, Guess]:
    """The log's time, or its seconds with the nanoseconds in a column of their own."""
    names = {column.name: None for column in free}
    for name in names:
        for seconds, nanoseconds in (("sec", "nanosec"), ("secs", "nsecs"), ("sec", "nsec"), ("seconds", "nanos")):
            other = name[: len(name) - len(seconds)] + nanoseconds
            if name.endswith(seconds) and not name.endswith(nanoseconds) and other in names:
                return {"time": Guess(NamedColumn(name), BY_NAME, other)}
    clocks = [column for column in free if column.is_clock and column.index is None]
    exact = [column for column in clocks if column.name.lower() in ("timestamp", "t", "stamp")]
    return {"time": Guess((exact or clocks)[0], BY_NAME)} if clocks else {}
