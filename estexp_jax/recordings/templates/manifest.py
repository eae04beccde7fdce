"""`estexp check --init`: a first manifest, with guesses at what the columns of a log are."""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

import mujoco
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.bind import check_names, column_names
from estexp_jax.recordings.inputs import is_manifest, parse_maps
from estexp_jax.recordings.readers.read import read_table
from estexp_jax.recordings.table import Selection
from estexp_jax.runs.files import write_text

# Words that logs use. Those of a command are looked for first: `goal_position` is one.
_COMMAND = {"command", "commanded", "cmd", "ctrl", "control", "goal", "target", "action", "desired", "con"}
_SWITCH = {"enable", "enabled"}
_READING = {
    mujoco.mjtSensor.mjSENS_JOINTPOS: {"position", "pos", "angle", "q", "encoder"},
    mujoco.mjtSensor.mjSENS_JOINTVEL: {"velocity", "vel", "speed", "qd", "dq"},
}
_NAMELESS = _COMMAND.union(
    _SWITCH, *_READING.values(), {"meas", "measured", "tau", "torque", "joint", "motor", "servo"}
)
"""Words that say what a column is, not whose."""
_CLOCK, _CLOCK_UNITS = {"time", "timestamp", "stamp", "t"}, ("ns", "us", "ms")


def write_manifest(
    path: Path, files: Sequence[str], test: Sequence[str], maps: Sequence[str], root: Path | None = None
) -> None:
    """Write a first `recordings.toml`.

    Args:
        path: the file; it must not exist.
        files: an MJCF and logs.
        test: logs with the role `test`.
        maps: `ours=theirs`, which are not guessed then.
        root: the folder that the model's files have to be under; None: see `Robot.from_xml`.

    Raises:
        InputError: the file exists, or cannot be written; no model and log are given, or they cannot be read.
    """
    if is_manifest(files) or not files or len(files) + len(test) < 2:
        raise InputError("no model and logs to begin a manifest with", where="--init", right="nominal.xml a.csv b.csv")
    if path.exists():
        raise InputError("exists already", where=str(path), right="move it away, or check it without --init")
    robot = Robot.from_xml(files[0], root)
    logs = [(log, "train") for log in files[1:]] + [(log, "test") for log in test]
    names = list(dict.fromkeys(name for log, _ in logs for name in _names(log)))
    given = {ours: str(source.column) for ours, source in parse_maps(maps).items()}
    check_names(robot, given, "--map")
    lines = [*_head(files[0], path.parent), *_columns(robot, names, given), *_recordings(logs, path.parent)]
    write_text(path, "\n".join(lines) + "\n")


def _names(log: str) -> tuple[str, ...]:
    """Names of a log's columns, and of the values in its list columns; of a data set, as its first episode has them."""
    table = read_table(log, Selection(episode=0 if Path(log).is_dir() else None))
    named = {column for column, _ in table.parts.values()}
    return (*(name for name in table.names if name not in named), *table.parts)


def guess(robot: Robot, names: Iterable[str]) -> dict[str, str]:
    """Which of a log's columns may be ours, by their names: `ctrl.Elbow` is `command_Elbow`.

    Args:
        robot: whose columns are wanted.
        names: the log's columns.

    Returns:
        Our column to theirs. Ours that the log has under our own name are left out, and so are those that no column
        resembles.
    """
    names = list(names)
    free = [name for name in names if name not in column_names(robot)]
    clocks = [name for name in free if set(_words(name)) & _CLOCK]
    switches = [name for name in free if set(_words(name)) & _SWITCH]
    commands = [name for name in free if set(_words(name)) & _COMMAND and name not in switches]
    found = {"time": clocks[0]} if clocks else {}
    found |= _matched("ctrl", _with_one_input(robot), commands) | _matched("enable", _actuators(robot), switches)
    for kind, words in _READING.items():
        found |= _matched(
            "sensor", _sensors(robot, kind), [n for n in free if n not in commands and set(_words(n)) & words]
        )
    return {ours: theirs for ours, theirs in found.items() if ours not in names}


def _words(name: str) -> list[str]:
    """`pos_meas1` is pos, meas and 1; `goalPosition` is goal and position."""
    return [word.lower() for word in re.findall(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|\d+", name)]


def _owner(name: str) -> list[str]:
    return [word for word in _words(name) if word not in _NAMELESS]


def _actuators(robot: Robot) -> dict[str, str]:
    """Each actuator and the joint it drives, or itself."""
    joints = [robot.joint_of_actuator(index) for index in range(robot.model.nactuator)]
    pairs = zip(robot.names("actuator"), joints, strict=True)
    return {name: name if joint is None else robot.names("joint")[joint] for name, joint in pairs}


def _with_one_input(robot: Robot) -> dict[str, str]:
    """Each actuator with one command, as of `_actuators`."""
    names = robot.command_columns()
    return {name: joint for name, joint in _actuators(robot).items() if name in names}


def _sensors(robot: Robot, kind: mujoco.mjtSensor) -> dict[str, str]:
    """Each sensor of a kind and its joint."""
    found = np.flatnonzero(robot.model.sensor_type == kind).tolist()
    joints = {index: robot.names("joint")[robot.model.sensor_objid[index]] for index in found}
    return {robot.names("sensor")[index]: joint for index, joint in joints.items()}


def _matched(prefix: str, elements: Mapping[str, str], columns: Sequence[str]) -> dict[str, str]:
    """Columns that bear the name of an element or of its joint; if none does and there are as many, in their order."""
    matched: dict[str, str] = {}
    for name, joint in elements.items():
        owners = [owner for owner in (_owner(name), _owner(joint)) if owner]
        fitting = [column for column in columns if _owner(column) in owners]
        if len(fitting) == 1:
            matched[f"{prefix}.{name}"] = fitting[0]
    if not matched and len(elements) == len(columns):
        matched = {f"{prefix}.{name}": column for name, column in zip(elements, columns, strict=True)}
    return matched


def _head(model: str, folder: Path) -> list[str]:
    return [
        "# A first manifest, to be completed by hand. Ours = theirs; SI, or a unit or scale that leads there.",
        f"model = {_path(model, folder)}",
        "",
        "[columns]",
    ]


def _columns(robot: Robot, names: Sequence[str], given: Mapping[str, str]) -> list[str]:
    guesses, lines = guess(robot, names), []
    for ours in column_names(robot):
        if ours in given:
            lines.append(f"{_key(ours)} = {_source(ours, given[ours])}")
        elif ours in guesses:
            lines.append(f"{_key(ours)} = {_source(ours, guesses[ours])}  # a guess, by its name")
        elif ours not in names and (ours == "time" or ours.startswith("ctrl.")):
            lines.append(f'# {_key(ours)} = "?"  # needed; for a constant command: {{ value = 0.0 }}')
        elif ours not in names and ours.startswith("sensor."):
            lines.append(f'# {_key(ours)} = "?"')
    used = {*given.values(), *guesses.values(), *column_names(robot)}
    rest = ", ".join(name for name in names if name not in used)
    return [*lines, f"# Columns of the logs that are not used: {rest or 'none'}"]


def _source(ours: str, theirs: str) -> str:
    unit = next((unit for unit in _CLOCK_UNITS if ours == "time" and _words(theirs)[-1:] == [unit]), None)
    return _text(theirs) if unit is None else f'{{ column = {_text(theirs)}, unit = "{unit}" }}'


def _recordings(logs: Sequence[tuple[str, str]], folder: Path) -> list[str]:
    lines: list[str] = []
    for log, role in logs:
        episode = ["episode = 0"] if Path(log).is_dir() else []
        lines += ["", "[[recording]]", f"file = {_path(log, folder)}", *episode, f'role = "{role}"']
    return lines


def _key(ours: str) -> str:
    return ours if ours == "time" else _text(ours)


def _path(path: str, folder: Path) -> str:
    """A path as the manifest's folder sees it."""
    return _text(Path(os.path.relpath(path, folder)).as_posix())


def _text(value: str) -> str:
    # What JSON writes is a TOML string as well.
    return json.dumps(value, ensure_ascii=False)
