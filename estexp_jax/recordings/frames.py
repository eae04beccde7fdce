"""Recordings that are in memory, from Python: data frames, dictionaries of arrays, structured arrays; and globs."""

from __future__ import annotations

import glob
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, final

import numpy as np

from estexp_jax.errors import InputError, abbreviated
from estexp_jax.recordings.readers.arrow import arrays_of, columns_of, table_of
from estexp_jax.recordings.readers.npz import array_columns, plain_table
from estexp_jax.recordings.table import Table, check_size


@final
@dataclass(frozen=True, eq=False)
class Frame:
    """A recording in memory.

    Attributes:
        data: a data frame of pandas, polars or Arrow, a mapping from column names to arrays, or a structured array.
        name: of the recording.
    """

    data: Any
    name: str


Log = str | Frame
"""The path of a log, or one in memory."""


class ArrowStream(Protocol):
    """A data frame that shows its columns to Arrow, as those of pandas and polars do."""

    def __arrow_c_stream__(self, requested_schema: object | None = None) -> object:
        """Arrow's own view of the columns."""
        ...


Logs = str | Path | ArrowStream | Mapping[str, Any] | np.ndarray | Iterable[Any]
"""A log as Python gives it, see `logs_of`, or several."""


def logs_of(given: Logs, prefix: str = "frame") -> list[Log]:
    """The logs that a caller from Python gives: one, or several.

    Args:
        given: a path, a glob, a frame (see `Frame`), a mapping from names to frames, or an iterable of these.
        prefix: of the names of frames without one.

    Raises:
        InputError: it is none of these, or no file fits a glob.
    """
    if isinstance(given, str | Path) or _is_frame(given):
        given = [given]
    if isinstance(given, Mapping):
        return [Frame(frame, str(name)) for name, frame in given.items()]
    logs: list[Log] = []
    for each in given if isinstance(given, Iterable) else [given]:
        if isinstance(each, str | Path):
            logs += _paths(str(each))
        elif _is_frame(each):
            logs.append(Frame(each, f"{prefix}_{len(logs)}"))
        else:
            right = "a path, a data frame, a dictionary of arrays, or a list of these"
            raise InputError(f"is {abbreviated(type(each).__name__)}, not a recording", where="recordings", right=right)
    return logs


def _is_frame(given: Any) -> bool:
    if isinstance(given, Mapping):
        return not any(_is_frame(value) for value in given.values())
    structured = isinstance(given, np.ndarray) and given.dtype.names is not None
    return structured or hasattr(given, "__arrow_c_stream__") and hasattr(given, "columns")


def _paths(path: str) -> list[str]:
    """The path itself, or the files that it fits as a glob."""
    if not glob.has_magic(path) or Path(path).exists():
        return [path]
    found = sorted(glob.glob(path, recursive=True))
    if not found:
        raise InputError("no file fits", where=path, right="the path of a log, or a glob such as logs/*.csv")
    return found


def frame_table(frame: Frame) -> Table:
    """The columns of a frame; an index that is no plain count of rows is a column as well.

    Raises:
        InputError: its columns cannot be read, or it is too large.
    """
    data = frame.data
    if isinstance(data, np.ndarray):
        columns = array_columns(frame.name, data, alone=True)
        return plain_table(columns, {}, frame.name, label=frame.name)
    if isinstance(data, Mapping):
        arrays = {str(name): np.asarray(values) for name, values in data.items()}
        check_size(sum(values.size for values in arrays.values()), frame.name)
        return plain_table(arrays, {}, frame.name, label=frame.name)
    import pyarrow

    try:
        table = pyarrow.table(data)
    except (pyarrow.ArrowException, TypeError, ValueError) as error:
        raise InputError(f"cannot be read: {' '.join(str(error).split())[:200]}", where=frame.name) from None
    columns = columns_of(table.schema, bool, frame.name)
    check_size(table.num_rows * max(len(columns.readable), 1), frame.name)
    return table_of(
        arrays_of(table, columns.readable, frame.name, columns.unusable), columns, frame.name, label=frame.name
    )
