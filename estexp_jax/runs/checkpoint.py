"""Checkpoints: a nested structure in one file, restored to the last bit."""

from __future__ import annotations

import json
import struct
import tokenize
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.runs.files import replacing

_TREE = "tree"
_KINDS = "biufcSUMm"
"""NumPy's kinds of dtype that need no pickle."""
# Exceptions from reading a truncated or damaged archive.
_DAMAGE = (OSError, EOFError, ValueError, KeyError, IndexError, TypeError, RuntimeError, MemoryError)
_DAMAGE += (zipfile.BadZipFile, zlib.error, struct.error, tokenize.TokenError, RecursionError)


def previous_of(path: str | Path) -> Path:
    """The path of the checkpoint before the one at `path`."""
    path = Path(path)
    return path.with_name(f"{path.name}.previous")


def save_checkpoint(path: str | Path, tree: Any) -> None:
    """Write a checkpoint; the previous one is kept beside it.

    If the run is killed at any moment, either this checkpoint or the previous one can be loaded.

    Args:
        path: the file; its folder must exist.
        tree: dicts, lists and tuples of str, int, float, bool, None, NumPy numbers and arrays. Other arrays (JAX) are
            saved as NumPy's. Subclasses are refused, as a named tuple would come back as another type.

    Raises:
        TypeError: the tree contains another type; names its place.
    """
    path = Path(path)
    arrays: list[np.ndarray] = []
    text = json.dumps(_encoded(tree, arrays, "checkpoint"))
    with replacing(path, previous=previous_of(path)) as stream:
        np.savez(stream, **{_TREE: np.frombuffer(text.encode(), np.uint8)}, **_named(arrays))


def load_checkpoint(path: str | Path) -> Any:
    """Read the checkpoint at `path`, or the previous one if that is damaged or missing.

    Returns:
        The saved tree, equal in every bit and type; None if there is no checkpoint.

    Raises:
        InputError: checkpoints exist, but none can be read.
    """
    path = Path(path)
    existing = [file for file in (path, previous_of(path)) if file.exists()]
    for file in existing:
        try:
            return _read(file)
        except _DAMAGE:
            continue
    if existing:
        raise InputError("the checkpoint is damaged", where=str(path), right="begin anew with --force")
    return None


def _named(arrays: list[np.ndarray]) -> dict[str, Any]:
    return {f"array_{index}": values for index, values in enumerate(arrays)}


def _read(file: Path) -> Any:
    # Reading a member in full verifies its checksum.
    with file.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
        text = archive[_TREE].tobytes().decode()
        return _decoded(json.loads(text), archive)


def _encoded(value: Any, arrays: list[np.ndarray], place: str) -> Any:
    """JSON of a tree: exact JSON types as they are, all others as a list that begins with the type."""
    kind = type(value)
    if value is None or kind in (str, int, float, bool):
        return value
    if kind in (list, tuple):
        return [kind.__name__, *(_encoded(item, arrays, f"{place}[{i}]") for i, item in enumerate(value))]
    if kind is dict:
        pairs = ((_encoded(key, arrays, f"a key of {place}"), item, f"{place}[{key!r}]") for key, item in value.items())
        return ["dict", *([key, _encoded(item, arrays, where)] for key, item, where in pairs)]
    if hasattr(value, "__array__") and (values := np.asarray(value)).dtype.kind in _KINDS:
        arrays.append(values)
        return ["number" if isinstance(value, np.generic) else "array", len(arrays) - 1]
    what = f" of {value.dtype}" if hasattr(value, "dtype") else ""
    raise TypeError(f"{place} is a {kind.__name__}{what}, which a checkpoint cannot hold")


def _decoded(node: Any, archive: Mapping[str, np.ndarray]) -> Any:
    if not isinstance(node, list):
        return node
    kind, items = node[0], node[1:]
    if kind == "dict":
        return {_decoded(key, archive): _decoded(item, archive) for key, item in items}
    if kind in ("array", "number"):
        values = archive[f"array_{items[0]}"]
        return values if kind == "array" else values[()]
    decoded = [_decoded(item, archive) for item in items]
    return tuple(decoded) if kind == "tuple" else decoded
