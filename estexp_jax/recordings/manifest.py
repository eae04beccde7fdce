"""The manifest `recordings.toml`: which model, which recordings, and what their columns mean."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from estexp_jax.errors import InputError, abbreviated, known
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import ROLES, Recording
from estexp_jax.recordings.bind import check_names, read_recording
from estexp_jax.recordings.columns import Source, parse_number, parse_source
from estexp_jax.recordings.settings import apply_settings
from estexp_jax.recordings.table import CLOCKS, Selection

_MOST_BYTES, _MOST_DEPTH = 4 * 2**20, 16
_TEXTS = re.compile(r'''"""(?:\\.|[^\\])*?"""|\'\'\'.*?\'\'\'|"(?:\\.|[^"\\\n])*"|\'[^\'\n]*\'|#[^\n]*''', re.DOTALL)
"""Texts and comments of TOML, in which dots and brackets mean nothing."""


@final
@dataclass(frozen=True, eq=False)
class Manifest:
    """A manifest and the recordings that it lists.

    Attributes:
        path: the manifest.
        model: path of the MJCF.
        robot: the MJCF compiled; the recordings' settings are not applied to it.
        columns: our column name to its source in the logs.
        recordings: in the manifest's order, with the roles it gives (`train` where it gives none).
    """

    path: Path
    model: Path
    robot: Robot
    columns: Mapping[str, Source]
    recordings: tuple[Recording, ...]


def read_manifest(path: str | Path, *, mend: bool = False, root: str | Path | None = None) -> Manifest:
    """Read a manifest, its model and its recordings. Paths in it are relative to it.

    Args:
        path: the manifest.
        mend: drop rows whose clock stands still or runs backwards, instead of refusing the log (see `read_recording`).
        root: the folder that the model's files have to be under; None: see `Robot.from_xml`.

    Raises:
        InputError: a file is missing or cannot be read, the TOML is broken (with its line), a key is unknown or of the
            wrong type, a setting does not fit the model, or a recording does not fit the robot.
    """
    path = Path(path)
    document = _document(path)
    _only(document, ("model", "columns", "recording"), str(path))
    model = path.parent / _text(document, "model", str(path), "the path of an MJCF file, relative to this one")
    if not _exists(model, file=True):
        right = "a path relative to the manifest"
        raise InputError(f"no such MJCF file '{model}'", where=f"{path}, model", right=right)
    robot = Robot.from_xml(model, root)
    columns = _columns(document.get("columns", {}), robot, f"{path}, [columns]")
    entries = document.get("recording", [])
    if not isinstance(entries, list) or not entries:
        raise InputError("lists no recordings", where=str(path), right='[[recording]] with file = "log.csv"')
    places = [f"{path}, [[recording]] {index}" for index in range(1, len(entries) + 1)]
    pairs = zip(entries, places, strict=True)
    recordings = tuple(_recording(entry, robot, columns, path, where, mend) for entry, where in pairs)
    return Manifest(path, model, robot, columns, recordings)


def _refuse_deep(text: str, where: str) -> None:
    """See that keys and lists are not nested without end: the parser's time and memory grow with the square of it."""
    bare, depth = _TEXTS.sub("x", text), 0
    for number, line in enumerate(bare.splitlines(), 1):
        dots = max(part.count(".") for part in re.split(r"[=,{}\[\]]", line))
        for bracket in re.findall(r"[\[{]|[\]}]", line):
            depth = depth + 1 if bracket in "[{" else max(depth - 1, 0)
            dots = max(dots, depth)
        if dots > _MOST_DEPTH:
            raise InputError(f"line {number} is nested more than {_MOST_DEPTH} deep", where=where, right="plain tables")


def _document(path: Path) -> dict[str, Any]:
    if not _exists(path, file=True):
        raise InputError("no such manifest", where=str(path), right="give the path of a recordings.toml")
    try:
        if path.stat().st_size > _MOST_BYTES:
            raise InputError(f"is {path.stat().st_size:,} bytes long", where=str(path), right="a short description")
        text = path.read_text(encoding="utf-8")
        _refuse_deep(text, str(path))
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"is not valid TOML: {error}", where=str(path)) from None
    except RecursionError:
        raise InputError("is nested too deeply", where=str(path), right="tables as in the README") from None
    except (OSError, ValueError) as error:
        raise InputError(f"cannot be read: {error}", where=str(path), right="UTF-8 text") from None


def _only(table: Mapping[str, Any], keys: Iterable[str], where: str) -> None:
    for key in table:
        if key not in keys:
            raise InputError(f"unknown key '{key}'", where=where, right=known(keys))


def _text(table: Mapping[str, Any], key: str, where: str, right: str) -> str:
    if key not in table:
        raise InputError(f"has no `{key}`", where=where, right=right)
    if not isinstance(table[key], str):
        raise InputError(f"{key} is {abbreviated(table[key])}, not a text", where=where, right=right)
    return table[key]


def _table(value: object, where: str) -> dict[str, Any]:
    if not isinstance(value, dict):
        raise InputError(f"is {abbreviated(value)}, not a table", where=where)
    return value


def _columns(value: object, robot: Robot, where: str) -> dict[str, Source]:
    table = _table(value, where)
    for key, entry in table.items():
        if key in ("ctrl", "sensor", "qpos", "qvel", "enable") and isinstance(entry, dict):
            first = next(iter(entry), "")
            right = f'put names with dots in quotes: "{key}.{first}" = ...'
            raise InputError(f"'{key}' is a nested table", where=where, right=right)
    check_names(robot, table, where)
    sources = {key: parse_source(entry, f"{where}, '{key}'") for key, entry in table.items()}
    if "time" in sources and sources["time"].value is not None:
        raise InputError("time cannot be a constant", where=where, right="name a column of the logs")
    return sources


def _exists(path: Path, *, file: bool = False) -> bool:
    """Whether the path is a file, or (without `file`) a file or folder; False for a path that cannot exist."""
    try:
        return path.is_file() if file else path.is_file() or path.is_dir()
    except (OSError, ValueError):
        return False


def _recording(
    entry: object, robot: Robot, columns: Mapping[str, Source], path: Path, where: str, mend: bool
) -> Recording:
    table = _table(entry, where)
    _only(table, ("file", "episode", "clock", "role", "set"), where)
    file = path.parent / _text(table, "file", where, "the path of a log, relative to the manifest")
    if not _exists(file):
        raise InputError(f"no such recording '{file}'", where=where, right="a path relative to the manifest")
    role = table.get("role", "train")
    if role not in ROLES:
        raise InputError(f"role is {abbreviated(role)}", where=where, right=known(ROLES))
    settings = _settings(table.get("set", {}), f"{where}, set")
    apply_settings(robot, settings, where=f"{where}, set")  # reported now, not in the middle of a fit
    part = _selection(table, where)
    return read_recording(robot, file, role=role, mapping=columns, settings=settings, selection=part, mend=mend)


def _selection(table: Mapping[str, Any], where: str) -> Selection:
    """Which episode of a LeRobot data set, and which clock of an MCAP file."""
    episode, clock = table.get("episode"), table.get("clock", CLOCKS[0])
    if episode is not None and (isinstance(episode, bool) or not isinstance(episode, int) or not 0 <= episode < 2**40):
        raise InputError(f"episode is {abbreviated(episode)}", where=where, right="a whole number from 0")
    if clock not in CLOCKS:
        raise InputError(f"clock is {abbreviated(clock)}", where=where, right=known(CLOCKS))
    return Selection(episode=episode, clock=clock)


def _settings(value: object, where: str) -> dict[str, float | tuple[float, ...]]:
    settings: dict[str, float | tuple[float, ...]] = {}
    for key, entry in _table(value, where).items():
        place = f"{where}, '{key}'"
        if isinstance(entry, dict):
            right = 'put the whole key in quotes: "actuator.servo.kp" = 1.0'
            raise InputError("is a nested table", where=place, right=right)
        if isinstance(entry, list):
            settings[key] = tuple(parse_number(item, place) for item in entry)
        else:
            settings[key] = parse_number(entry, place)
    return settings
