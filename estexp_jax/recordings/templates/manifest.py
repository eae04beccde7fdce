"""`estexp check --init`: a first manifest, with guesses at what the columns of a log are."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import numpy as np

from estexp_jax.errors import InputError, printable
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.bind import check_names, column_names
from estexp_jax.recordings.checks.clock_units import CLOCK_UNITS, likely_clock_unit
from estexp_jax.recordings.inputs import is_manifest, parse_maps
from estexp_jax.recordings.readers.messages import MOST_VALUES
from estexp_jax.recordings.readers.read import holds_episodes, read_table
from estexp_jax.recordings.table import Selection
from estexp_jax.recordings.templates.guess import guesses
from estexp_jax.recordings.templates.matching import Guess
from estexp_jax.recordings.templates.names import NamedColumn
from estexp_jax.runs.files import write_text

_MOTION_UNITS = ("mrad", "deg", "deg/s", "rpm", "cm", "mm")


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
    contents = _contents([log for log, _ in logs])
    given = {ours: str(source.column) for ours, source in parse_maps(maps).items()}
    check_names(robot, given, "--map")
    lines = [*_head(files[0], path.parent), *_columns(robot, contents, given), *_recordings(logs, path.parent)]
    write_text(path, "\n".join(lines) + "\n")


@final
@dataclass(frozen=True, eq=False)
class _Contents:
    """What logs hold.

    Attributes:
        columns: of all logs, single values of list columns among them.
        times: (rows,) values of columns of one number a row, of the first log that has them.
    """

    columns: Sequence[NamedColumn]
    times: Mapping[str, np.ndarray]


def _contents(logs: Sequence[str]) -> _Contents:
    """The columns of logs; of a data set, as its first episode has them."""
    columns: dict[NamedColumn, None] = {}
    times: dict[str, np.ndarray] = {}
    for log in logs:
        table = read_table(log, Selection(episode=0 if holds_episodes(log) else None))
        named = {column for column, _ in table.parts.values()}
        for name in (*(name for name in table.names if name not in named), *table.parts):
            values = table.columns.get(name, np.empty(0))
            many = values.ndim == 2 and values.shape[1] <= MOST_VALUES
            columns |= (
                dict.fromkeys(NamedColumn(name, k) for k in range(values.shape[1]))
                if many
                else {NamedColumn(name, None, *table.labels.get(name, ())): None}
            )
            if values.ndim == 1 and name not in table.stamps:
                times.setdefault(name, values)
    return _Contents(list(columns), times)


def _head(model: str, folder: Path) -> list[str]:
    return [
        "# A first manifest, to be completed by hand. Ours = theirs; SI, or a unit or scale that leads there.",
        f"model = {_path(model, folder)}",
        "",
        "[columns]",
    ]


def _columns(robot: Robot, contents: _Contents, given: Mapping[str, str]) -> list[str]:
    found, lines, used = guesses(robot, contents.columns), [], {*given.values(), *column_names(robot)}
    names = {column.name for column in contents.columns}
    for ours in column_names(robot):
        guess = found.get(ours)
        if ours in given:
            lines.append(f"{_key(ours)} = {_source(ours, Guess(NamedColumn(given[ours]), ''), contents)[0]}")
        elif guess is not None and guess.column is not None:
            source, unit_note = _source(ours, guess, contents)
            lines.append(f"{_key(ours)} = {source}  # {guess.why}{unit_note}")
            used |= {guess.column.name, guess.nanoseconds or ""}
        elif guess is not None:
            lines.append(f'# {_key(ours)} = "?"  # {printable(guess.why)}')
        elif ours == "time" and ours in names:
            source, unit_note = _source(ours, Guess(NamedColumn(ours), ""), contents)
            lines += [f"time = {source}  # {unit_note.removeprefix('; ')}"] if unit_note else []
        elif ours not in names and ours == "time":
            lines.append('# time = "?"  # needed; of a log without a clock, its rate: { hz = 50.0 }')
        elif ours not in names and ours.startswith("ctrl."):
            lines.append(f'# {_key(ours)} = "?"  # needed; for a constant command: {{ value = 0.0 }}')
        elif ours not in names and ours.startswith("sensor."):
            lines.append(f'# {_key(ours)} = "?"')
    rest = ", ".join(dict.fromkeys(c.name for c in contents.columns if c.name not in used))
    return [*lines, f"# Columns of the logs that are not used: {printable(rest) or 'none'}"]


def _source(ours: str, guess: Guess, contents: _Contents) -> tuple[str, str]:
    """What a manifest says of a column, and a remark on its unit."""
    column = guess.column or NamedColumn("")
    if guess.nanoseconds is not None:
        return f"{{ column = {_text(column.name)}, nanoseconds = {_text(guess.nanoseconds)} }}", ""
    unit, note = column.unit, ""
    if unit not in (CLOCK_UNITS if ours == "time" else _MOTION_UNITS):
        unit = ""
    if ours == "time" and not unit and column.name in contents.times:
        unit = likely_clock_unit(contents.times[column.name])
        note = "; its unit by its values: check this" if unit else ""
    extra = [f"index = {column.index}"] if column.index is not None else []
    extra += [f'unit = "{unit}"'] if unit else []
    if not extra:
        return _text(column.name), note
    return f"{{ column = {_text(column.name)}, {', '.join(extra)} }}", note


def _recordings(logs: Sequence[tuple[str, str]], folder: Path) -> list[str]:
    lines: list[str] = []
    for log, role in logs:
        episode = ["episode = 0"] if holds_episodes(log) else []
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
