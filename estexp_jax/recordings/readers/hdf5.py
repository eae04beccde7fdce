"""Read HDF5 logs, MATLAB's (v7.3) among them: one data set a column, named by its path."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.npz import array_columns, plain_table
from estexp_jax.recordings.table import MOST_COLUMNS, Selection, Table, check_size, check_width

_EPISODE = re.compile(r"(?:demo|episode|traj)_?(\d+)")
_MATLAB = "MATLAB_class"


def read_hdf5(path: Path, selection: Selection) -> Table:
    """Read an HDF5 file: numbers (rows,) or (rows, k), tables of named fields. Links to other files are not followed.

    A file of several demonstrations (robomimic's `data/demo_0`, ...) holds an episode each.

    Raises:
        InputError: the file is not HDF5 or too large, an episode is missing or was not chosen among several, or the
            extra `hdf5` is not installed.
    """
    try:
        import h5py
    except ImportError:
        right = "pip install 'estexp_jax[hdf5]'"
        raise InputError("is HDF5, which needs the extra `hdf5`", where=str(path), right=right) from None
    columns: dict[str, np.ndarray] = {}
    unusable: dict[str, InputError] = {}
    unread: list[str] = []
    label = ""
    try:
        with h5py.File(path, "r") as file:
            root, label = _chosen_root(file, selection, path)
            for name, data in _data_sets(root):
                why, where = _reason_unreadable(data), f"{path}, column '{name}'"
                if not selection.asks_for(name):
                    unread.append(name)
                elif why:
                    unusable[name] = InputError(f"is no column of numbers: {why}", where=where)
                else:
                    check_size(sum(v.size for v in columns.values()) + data.size * max(1, len(data.dtype)), where)
                    columns |= array_columns(name, _values(data), alone=False)
                check_width(len(columns) + len(unusable), str(path))
    except InputError:
        raise
    except Exception as error:  # a parser may raise anything on damaged bytes
        reason = " ".join(f"{error or type(error).__name__}".split())[:200]
        right = "an HDF5 file; MATLAB writes one with save -v7.3"
        raise InputError(f"is not an HDF5 file, or is damaged: {reason}", where=str(path), right=right) from None
    return plain_table(columns, unusable, str(path), label=label, unread=tuple(unread))


def hdf5_episodes(path: Path) -> bool:
    """Whether an HDF5 file holds several demonstrations; False for what cannot be read."""
    try:
        import h5py

        with h5py.File(path, "r") as file:
            return len(_episodes(file)) > 1
    except Exception:  # told when it is read
        return False


def _episodes(file: Any) -> dict[int, str]:
    """The groups of demonstrations by their numbers."""
    import h5py

    for place in ("data", "/"):
        group = file.get(place) if place == "/" or isinstance(file.get(place, getlink=True), h5py.HardLink) else None
        names = list(group)[:MOST_COLUMNS] if isinstance(group, h5py.Group) else []
        found = {int(match[1]): f"{place.strip('/')}/{name}" for name in names if (match := _EPISODE.fullmatch(name))}
        if found:
            return dict(sorted(found.items()))
    return {}


def _chosen_root(file: Any, selection: Selection, path: Path) -> tuple[Any, str]:
    """The group that is the recording, and its name where it is one of several."""
    found, episode = _episodes(file), selection.episode
    right = f"choose one with `episode = 0` under [[recording]] in a manifest; there are: {_listed(found)}"
    if episode is None and len(found) > 1:
        raise InputError("holds several episodes", where=str(path), right=right)
    if episode is not None and episode not in found:
        raise InputError(f"has no episode {episode}", where=str(path), right=right)
    if not found:
        return file, ""
    episode = next(iter(found)) if episode is None else episode
    return file[found[episode]], f"{path.stem}_episode_{episode}{path.suffix}"


def _listed(found: dict[int, str]) -> str:
    return ", ".join(map(str, list(found)[:20])) + (", ..." if len(found) > 20 else "") if found else "none"


def _data_sets(group: Any, prefix: str = "", depth: int = 0) -> Iterator[tuple[str, Any]]:
    """All data sets in a group, by their paths; links within the file or to others are left out."""
    import h5py

    for name in group:
        if not isinstance(group.get(name, getlink=True), h5py.HardLink) or name.startswith("#") or depth > 20:
            continue
        member = group[name]
        if isinstance(member, h5py.Group):
            yield from _data_sets(member, f"{prefix}{name}/", depth + 1)
        elif isinstance(member, h5py.Dataset):
            yield f"{prefix}{name}", member


def _reason_unreadable(data: Any) -> str:
    """Why a data set is no column; empty if it is one."""
    if data.is_virtual or data.external:
        return "its values lie in other files"
    if data.attrs.get("MATLAB_empty", 0) or data.shape is None:
        return "it is empty"
    if data.dtype.names is None and data.dtype.kind not in "fiub":
        return f"it holds {data.dtype}"
    if data.dtype.hasobject:
        return "it holds texts or references"
    return "" if data.ndim in (1, 2) else f"its shape is {data.shape}, not (rows,) or (rows, values)"


def _values(data: Any) -> np.ndarray:
    """The values; MATLAB's columns are rows in the file, and its vectors have two dimensions."""
    values = np.asarray(data[()])
    if _MATLAB not in data.attrs:
        return values
    return values.ravel() if min(values.shape) == 1 else values.T
