"""Atomic writes of files, and results as plain JSON."""

from __future__ import annotations

import io
import json
import math
import os
import socket
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from estexp_jax.errors import unwritable

_DRAFT = ".part"


def draft_of(path: Path) -> Path:
    """Where this process writes a file before renaming it; a killed run leaves it behind.

    Each process has its own draft, also across machines that share the folder, so they do not overwrite each other.
    """
    return path.with_name(f".{path.name}.{socket.gethostname()}-{os.getpid()}{_DRAFT}")


def drafts_of(path: Path) -> list[Path]:
    """The drafts of a file: left behind, or being written now."""
    if not path.parent.is_dir():
        return []
    return [item for item in path.parent.iterdir() if is_draft(item.name, path.name)]


def remove_drafts(folder: Path) -> None:
    """Remove the drafts that killed processes have left in a folder; no process may be writing there."""
    for draft in folder.glob(f".*{_DRAFT}"):
        with suppress(OSError):
            draft.unlink()


def is_draft(name: str, of: str) -> bool:
    """Whether `name` is the name of a draft of the file `of`."""
    return name.startswith(f".{of}.") and name.endswith(_DRAFT)


@contextmanager
def replacing(path: str | Path, *, previous: Path | None = None) -> Iterator[IO[bytes]]:
    """A stream whose contents become the file at the end, unless an error ends the block.

    Readers and killed runs find the old file or the new one, never a partial one. The contents are collected in memory,
    written to a draft in the same folder, synced to the disk, and then renamed. On a full disk the old file stays.

    Args:
        path: the file; its folder must exist. Of several writers, the last one wins.
        previous: path in the same folder at which the replaced file is kept.

    Raises:
        InputError: the disk is full, or the folder may not be written.
    """
    path = Path(path)
    with io.BytesIO() as stream:
        yield stream
        try:
            _replace(path, stream.getbuffer(), previous)
        except OSError as error:
            raise unwritable(path, error) from None


def _replace(path: Path, contents: memoryview, previous: Path | None) -> None:
    draft = draft_of(path)
    try:
        with draft.open("wb") as stream:
            stream.write(contents)
            stream.flush()
            os.fsync(stream.fileno())
        if previous is not None and path.exists():
            path.replace(previous)
        draft.replace(path)
        _sync_folder(path.parent)
    finally:
        contents.release()
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def _sync_folder(folder: Path) -> None:
    """Sync a rename to the disk; skipped where folders cannot be opened (Windows)."""
    try:
        handle = os.open(folder, os.O_RDONLY)
    except OSError:
        return
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


def write_text(path: str | Path, text: str) -> None:
    """Write a text (UTF-8) atomically.

    Args:
        path: the file; its folder must exist.
        text: all of it.

    Raises:
        InputError: the disk is full, or the folder may not be written.
    """
    with replacing(path) as stream:
        stream.write(text.encode())


def write_json(path: str | Path, value: Any) -> None:
    """Write a result as JSON (UTF-8, indented) atomically.

    Args:
        path: the file; its folder must exist.
        value: anything `json_plain` accepts.

    Raises:
        TypeError: a part of `value` has no JSON form; names its place.
        InputError: the disk is full, or the folder may not be written.
    """
    write_text(path, f"{json.dumps(json_plain(value), indent=2, ensure_ascii=False, allow_nan=False)}\n")


def json_plain(value: Any, place: str = "value") -> Any:
    """A value as plain JSON types: dicts with text keys, lists, texts, numbers, booleans and None.

    Arrays become lists, dataclasses dicts, paths texts; numbers that are not finite become None.

    Args:
        value: of these types, nested.
        place: name of the value, for messages.

    Raises:
        TypeError: a part of it has no JSON form; names its place.
    """
    if value is None or isinstance(value, str | bool):
        return value
    if isinstance(value, np.generic):
        return json_plain(value.item(), place)
    if isinstance(value, int):
        return int(value)
    if isinstance(value, float):
        return float(value) if math.isfinite(value) else None
    if isinstance(value, Path):
        return str(value)
    if is_dataclass(value) and not isinstance(value, type):
        return {field.name: json_plain(getattr(value, field.name), f"{place}.{field.name}") for field in fields(value)}
    if isinstance(value, Mapping):
        return {_key(key, place): json_plain(item, f"{place}.{key}") for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [json_plain(item, f"{place}[{index}]") for index, item in enumerate(value)]
    if hasattr(value, "__array__"):
        return json_plain(np.asarray(value).tolist(), place)
    raise TypeError(f"{place} is a {type(value).__name__}, which has no JSON form")


def _key(key: object, place: str) -> str:
    if isinstance(key, str | int | np.integer) and not isinstance(key, bool):
        return str(key)
    raise TypeError(f"{place} has the key {key!r}; JSON's keys are texts")
