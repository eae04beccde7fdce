"""Tie a log's columns to a robot's actuators, sensors and joints."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from estexp_jax.errors import InputError, known, listing, printable
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.clock_repair import strictly_increasing
from estexp_jax.recordings.clocks import check_overlap, first_command, longest_run, row_times, sampled_span
from estexp_jax.recordings.columns import LARGEST, Source
from estexp_jax.recordings.first_inputs import several_inputs, with_first_inputs
from estexp_jax.recordings.readers.read import read_table
from estexp_jax.recordings.table import PREFIXES, Selection, Table

_READING_KINDS = ("sensor", "qpos", "qvel")
COORDINATES = {
    mujoco.mjtJoint.mjJNT_FREE: (7, 6),
    mujoco.mjtJoint.mjJNT_BALL: (4, 3),
    mujoco.mjtJoint.mjJNT_SLIDE: (1, 1),
    mujoco.mjtJoint.mjJNT_HINGE: (1, 1),
}
"""How many values each joint type has in qpos and in qvel."""


def read_recording(
    robot: Robot,
    path: str | Path,
    *,
    role: str = "train",
    mapping: Mapping[str, Source] | None = None,
    settings: Mapping[str, Any] | None = None,
    selection: Selection = Selection(),  # noqa: B008 frozen, so shared safely
    mend: bool = False,
    commands_alone: bool = False,
) -> Recording:
    """Read a log (.csv, .npz, .parquet, .mcap, the folder of a LeRobot data set) and tie it to a robot.

    Args:
        robot: whose actuators, sensors and joints the columns name.
        path: the log.
        role: `train` or `test`.
        mapping: our column name to its source, where the log uses other names.
        settings: known differences of this recording; stored, not applied (see `apply_settings`).
        selection: which episode or clock of the log; its `wanted` columns are taken from `mapping`.
        mend: drop rows whose time does not increase and report them in the notes, instead of refusing the log.
        commands_alone: take a log without any reading, too.

    Raises:
        InputError: the file cannot be read, or its contents do not fit the robot; names file, row and column.
    """
    sources = (mapping or {}).values()
    requested = frozenset(column for source in sources for column in source.columns) or None
    clocks = {source.column: source.clock for source in sources if source.column and source.clock}
    for source in sources:
        if source.column in clocks and source.clock != clocks[source.column]:
            raise InputError(f"'{source.column}' is read by two clocks", where=str(path), right="one clock a column")
    table = read_table(path, replace(selection, wanted=requested, clocks=clocks))
    more = {"settings": settings, "mend": mend, "commands_alone": commands_alone}
    return bind_columns(robot, table, role=role, mapping=mapping, **more)


def column_names(robot: Robot) -> tuple[str, ...]:
    """All column names that a recording of this robot may have."""
    return ("time", *_column_places(robot))


def check_names(robot: Robot, names: Iterable[str], where: str) -> None:
    """Check that each name is `time` or one of the robot's columns.

    Raises:
        InputError: a name does not exist on this robot; lists the names that do.
    """
    choices = column_names(robot)
    for name in names:
        if name not in choices and name not in several_inputs(robot):
            kind = next((prefix for prefix in PREFIXES if name.startswith(prefix)), "")
            right = known(choice for choice in choices if choice.startswith(kind))
            if robot.remedy and kind in ("ctrl.", "enable.", "sensor."):
                right += f"; {robot.remedy}"
            raise InputError(f"'{name}' names nothing on this robot", where=where, right=right)


def bind_columns(
    robot: Robot,
    table: Table,
    *,
    role: str = "train",
    mapping: Mapping[str, Source] | None = None,
    settings: Mapping[str, Any] | None = None,
    mend: bool = False,
    commands_alone: bool = False,
) -> Recording:
    """Tie a log's columns to a robot.

    A column is used if `mapping` names it as a source, or if it has one of our names that is not mapped. Our names are
    `time`, `ctrl.<actuator>`, `enable.<actuator>`, `sensor.<sensor>`, `qpos.<joint>` and `qvel.<joint>`, with
    `.0 .1 ...` where there are several values; `ctrl.<actuator>` of one with several inputs is the first of them, the
    others then at zero, as MuJoCo has them until they are set. Other columns are ignored and listed in the notes. An
    empty command or switch repeats the last one; a motor is on until a switch says otherwise. Rows before the first
    command of every actuator are left out.

    Args: as for `read_recording`.

    Raises:
        InputError: time is missing or does not increase; an actuator has no commands; two columns have clocks that do
            not overlap; there is no reading; a name is not on the robot; or a used column holds a text or infinity.
    """
    sources, input_notes = with_first_inputs(robot, _sources(robot, table, mapping or {}))
    notes: list[str] = []
    if "time" in sources:
        table, note = longest_run(table, sources["time"])
        notes += [note] if note else []
    if mend and "time" in sources:
        table, note = strictly_increasing(table, sources["time"])
        notes += [note] if note else []
    time = _time(table, sources)
    sizes = {"ctrl": robot.model.nu, "enable": robot.model.nactuator, "sensor": robot.model.nsensordata}
    sizes |= {"qpos": robot.model.nq, "qvel": robot.model.nv}
    arrays = {kind: np.full((len(time), size), np.nan) for kind, size in sizes.items()}
    arrays["enable"][:] = 1.0
    spans, commands = {}, {}
    for name, (kind, index) in _column_places(robot).items():
        if name in sources:
            values = _read_values(table, name, sources[name], len(time))
            column = sources[name].column
            if column is not None and kind != "enable" and (span := sampled_span(column, time, values)) is not None:
                spans[name] = span
            commands |= {name: values} if kind == "ctrl" else {}
            arrays[kind][:, index] = _fill_commands(table, name, sources[name], values, kind)
        elif kind == "ctrl":
            right = "every actuator needs its command: a column, a mapping, or a constant { value = 0.0 } in a manifest"
            right += f"; columns are: {_column_list(table)}"
            raise InputError(f"no column '{name}'", where=table.source, right=right)
    check_overlap(spans, table.source)
    first, note = first_command(commands, time, table.source)
    notes += [note] if note else []
    time, arrays = time[first:], {kind: values[first:] for kind, values in arrays.items()}
    if not (commands_alone or any(np.isfinite(arrays[kind]).any() for kind in _READING_KINDS)):
        names = ", ".join(name for name in _column_places(robot) if _kind(name) in _READING_KINDS)
        right = f"at least one column with samples of: {names}"
        raise InputError("no reading of any sensor or joint", where=table.source, right=right)
    notes += [*table.notes, *input_notes, *_notes(table, sources)]
    name = printable(table.label or Path(table.source).name)
    remarks = {"notes": tuple(notes), "clock_faults": ()}
    return Recording(name, time, **arrays, role=role, settings=dict(settings or {}), **remarks)


def log_columns(robot: Robot, recording: Recording) -> dict[str, np.ndarray]:
    """The columns (rows,) of a log of a recording, by our names: commands, and readings with samples."""
    columns = {"time": recording.time}
    for name, (kind, index) in _column_places(robot).items():
        values = getattr(recording, kind)[:, index]
        if kind == "ctrl" or (not values.all() if kind == "enable" else np.isfinite(values).any()):
            columns[name] = values
    return columns


def _column_places(robot: Robot) -> dict[str, tuple[str, int]]:
    """Each of our column names except `time`, with its array and its column in that array."""
    places: dict[str, tuple[str, int]] = {}
    for kind, names in (("ctrl", robot.command_columns()), ("enable", robot.names("actuator"))):
        places |= {f"{kind}.{name}": (kind, index) for index, name in enumerate(names)}
    places |= {f"sensor.{name}": ("sensor", index) for index, name in enumerate(robot.sensor_columns())}
    model = robot.model
    for kind, width, addresses in (("qpos", 0, model.jnt_qposadr), ("qvel", 1, model.jnt_dofadr)):
        for joint, name in enumerate(robot.names("joint")):
            size = COORDINATES[mujoco.mjtJoint(model.jnt_type[joint])][width]
            for k in range(size):
                places[f"{kind}.{name}" + (f".{k}" if size > 1 else "")] = (kind, int(addresses[joint]) + k)
    return places


def _kind(name: str) -> str:
    return name.partition(".")[0]


def _column_list(table: Table) -> str:
    return listing((*table.names, *table.parts)) or "none"


def _sources(robot: Robot, table: Table, mapping: Mapping[str, Source]) -> dict[str, Source]:
    """The source of each of our columns that is in this log."""
    check_names(robot, mapping, "mapping")
    theirs = {column for source in mapping.values() for column in source.columns}
    choices = {*column_names(robot), *several_inputs(robot)}
    own: dict[str, Source] = {}
    for name in table.names:
        if name not in choices and name in theirs:
            continue
        if name in choices or name.startswith(PREFIXES):
            check_names(robot, [name], f"{table.source}, column '{name}'")
            own[name] = Source(column=name)
    return own | dict(mapping)


def _read_values(table: Table, name: str, source: Source, rows: int) -> np.ndarray:
    values = source.read(table, rows)
    if source.column is None:
        return values
    if len(values) != rows:
        what = f"has {len(values)} rows, `time` has {rows}"
        raise InputError(what, where=f"{table.source}, column '{source.column}'")
    too_large = np.abs(values) > LARGEST
    if too_large.any():
        what = f"{'infinite value' if np.isinf(values[too_large][0]) else f'{values[too_large][0]:.4g}'} for {name}"
        where = table.place(int(np.argmax(too_large)), source.column)
        raise InputError(what, where=where, right=f"a finite number up to {LARGEST:g}, or an empty cell")
    return values


def _time(table: Table, sources: Mapping[str, Source]) -> np.ndarray:
    if "time" not in sources:
        right = "seconds, strictly increasing; map it if it has another name, or give the rate of rows without a clock,"
        right += f" time = {{ hz = 50 }} in a manifest; columns are: {_column_list(table)}"
        raise InputError("no column 'time'", where=table.source, right=right)
    return row_times(table, sources["time"])


def _fill_commands(table: Table, name: str, source: Source, values: np.ndarray, kind: str) -> np.ndarray:
    """Commands and switches with the last value held; readings unchanged."""
    if kind in _READING_KINDS:
        return values
    column = source.column or name
    empty = np.isnan(values)
    if kind == "enable":
        wrong = ~empty & (values != 0.0) & (values != 1.0)
        if wrong.any():
            row = int(np.argmax(wrong))
            what = f"{name} is {float(values[row])!r}"
            raise InputError(what, where=table.place(row, column), right="0 (motor off) or 1 (on)")
    last = np.maximum.accumulate(np.where(empty, -1, np.arange(len(values))))
    return np.where(last < 0, 1.0, values[last])


def _notes(table: Table, sources: Mapping[str, Source]) -> tuple[str, ...]:
    used = {column for source in sources.values() for column in source.columns}
    used |= {column for part, (column, _) in table.parts.items() if part in used}
    ignored = [name for name in table.names if name not in used]
    return (f"ignored columns: {listing(ignored)}",) if ignored else ()
