"""Numeric columns of Arrow tables: numbers, lists of one length, structs, time stamps and durations."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.stamps import is_stamp, seconds
from estexp_jax.recordings.table import Selection, Table, check_size, check_width

if TYPE_CHECKING:
    import pyarrow

_INTERVAL = ", as Parquet stores intervals, in whole milliseconds: write seconds instead, in DuckDB epoch(column)"


@final
@dataclass(frozen=True)
class ArrowColumns:
    """Which columns of an Arrow schema are read.

    Attributes:
        readable: names of numeric columns, those of a struct as `struct.field`.
        unusable: other columns, each with the error to raise if it is read.
        unread: names of columns that were not asked for.
    """

    readable: tuple[str, ...]
    unusable: dict[str, InputError]
    unread: tuple[str, ...]


def columns_of(schema: pyarrow.Schema, wanted: Callable[[str], bool], source: object) -> ArrowColumns:
    """Sort the columns of a schema.

    Args:
        schema: of a table.
        wanted: whether a column of this name is asked for.
        source: the log, for messages.

    Raises:
        InputError: there are too many.
    """
    leaves = [leaf for field in schema for leaf in _leaves(field.name, field.type)]
    check_width(len(leaves), str(source))
    counts = Counter(name for name, _ in leaves)
    readable, unread = dict[str, None](), dict[str, None]()
    unusable: dict[str, InputError] = {}
    for name, kind in leaves:
        why = "two columns have this name" if counts[name] > 1 else _reason_unreadable(kind)
        if not wanted(name):
            unread[name] = None
        elif why:
            unusable.setdefault(name, not_numeric(name, source, why))
        else:
            readable[name] = None
    return ArrowColumns(tuple(readable), unusable, tuple(unread))


def not_numeric(name: str, source: object, why: str) -> InputError:
    """The error to raise where a column is read that holds no numbers."""
    return InputError(f"is no column of numbers: {why}", where=f"{source}, column '{name}'")


def _leaves(name: str, kind: pyarrow.DataType) -> Iterator[tuple[str, pyarrow.DataType]]:
    from pyarrow import types

    inner = kind.fields if types.is_struct(kind) else ()
    leaves = [leaf for field in inner for leaf in _leaves(f"{name}.{field.name}", field.type)]
    if all(_reason_unreadable(leaf) for _, leaf in leaves):  # a picture, say
        yield name, kind
    yield from leaves


def _reason_unreadable(kind: pyarrow.DataType) -> str:
    """Why a column of this type is not numeric; empty if it is."""
    from pyarrow import types

    if types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind):
        inner = kind.value_type
        return "" if not types.is_nested(inner) and not _reason_unreadable(inner) else f"it holds lists of {inner}"
    number = is_plain(kind) or types.is_null(kind) or types.is_boolean(kind) or types.is_decimal(kind)
    time = types.is_timestamp(kind) or types.is_duration(kind) or types.is_time(kind)
    interval = _INTERVAL if types.is_fixed_size_binary(kind) and kind.byte_width == 12 else ""
    return "" if number or time else f"it holds {kind}{interval}"


def arrays_of(
    table: pyarrow.Table, readable: Sequence[str], source: object, unusable: dict[str, InputError]
) -> dict[str, np.ndarray]:
    """The readable columns as arrays (rows,) or (rows, k), float64 or of NumPy's kinds of time; nulls are NaN or NaT.

    They may be views of the table, not to be written to. Columns that prove not numeric go to `unusable`.
    """
    arrays: dict[str, np.ndarray] = {}
    wanted = set(readable)
    for name, values in _flattened((field.name, table.column(k)) for k, field in enumerate(table.schema)):
        try:
            arrays |= {name: _to_numpy(values.combine_chunks())} if name in wanted and name not in unusable else {}
        except ValueError as error:
            unusable.setdefault(name, not_numeric(name, source, str(error)))
    return {name: arrays[name] for name in readable if name in arrays}


def is_plain(kind: pyarrow.DataType) -> bool:
    """Whether each value of a type is one number, and no time."""
    from pyarrow import types

    return types.is_integer(kind) or types.is_floating(kind)


def empty_column(rows: int) -> np.ndarray:
    """An array (rows,) of float64 to be filled, in memory that comes from the system as it is.

    NumPy asks for huge pages, and Arrow's own pool prepares large blocks: both may take longer than to read the file.
    """
    import pyarrow

    return np.frombuffer(pyarrow.allocate_buffer(8 * rows, memory_pool=pyarrow.system_memory_pool()), np.float64)


def fill(target: np.ndarray, values: pyarrow.Array) -> None:
    """Put numbers into an array (rows,) that is there; nulls are NaN."""
    import pyarrow

    is_ready = values.type == pyarrow.float64() and not values.null_count
    target[:] = values.to_numpy() if is_ready else _to_numpy(values)


def _flattened(columns: Iterable[tuple[str, Any]]) -> Iterator[tuple[str, Any]]:
    from pyarrow import types

    for name, values in columns:
        if types.is_struct(values.type) and values.type.num_fields:
            names = [values.type.field(index).name for index in range(values.type.num_fields)]
            yield from _flattened((f"{name}.{n}", v) for n, v in zip(names, values.flatten(), strict=True))
        else:
            yield name, values


def _to_numpy(values: Any) -> np.ndarray:
    import pyarrow
    from pyarrow import compute, types

    if isinstance(values, pyarrow.ChunkedArray):
        values = pyarrow.concat_arrays(values.chunks) if values.num_chunks else pyarrow.array([], values.type)
    if types.is_time(values.type):
        values = values.cast(pyarrow.int32() if types.is_time32(values.type) else pyarrow.int64())
        return _to_numpy(values.cast(pyarrow.int64()).cast(pyarrow.duration(values.type.unit)))
    if types.is_timestamp(values.type) or types.is_duration(values.type):
        kind = "datetime64" if types.is_timestamp(values.type) else "timedelta64"
        counts = values.cast(pyarrow.int64())
        empty = np.asarray(counts.is_null().to_numpy(zero_copy_only=False), dtype=bool)
        whole = counts.fill_null(0).to_numpy(zero_copy_only=False).astype(f"{kind}[{values.type.unit}]")
        return np.where(empty, np.array("NaT", whole.dtype), whole)
    if not types.is_nested(values.type):
        return np.asarray(values.cast(pyarrow.float64(), safe=False).to_numpy(zero_copy_only=False), dtype=np.float64)
    lengths = compute.call_function("list_value_length", [values])
    width = compute.call_function("min_max", [lengths]).as_py()
    if width["min"] != width["max"]:
        raise ValueError("its lists differ in length")
    flat = _to_numpy(values.flatten())  # without the lists that are null
    there = np.asarray(values.is_valid().to_numpy(zero_copy_only=False), dtype=bool)
    whole = np.full((len(values), width["min"] or 0), np.array("NaT", flat.dtype) if is_stamp(flat) else np.nan)
    whole[there] = flat.reshape(int(there.sum()), width["min"] or 0)
    return whole


def table_of(arrays: dict[str, np.ndarray], columns: ArrowColumns, source: str, **more: Any) -> Table:
    """A log from its columns, time stamps as seconds.

    Args:
        arrays: as of `arrays_of`.
        columns: of its schema.
        source: the log, for messages.
        more: further attributes of the table.
    """
    stamps = frozenset(name for name, values in arrays.items() if is_stamp(values))
    plain = {name: seconds(values) if name in stamps else values for name, values in arrays.items()}
    return Table(source, plain, columns.unusable, stamps=stamps, unread=columns.unread, **more)


def read_feather(path: Path, selection: Selection) -> Table:
    """Read a Feather or Arrow IPC file, or stream, one batch at a time.

    Raises:
        InputError: it is not Arrow, or too large.
    """
    import pyarrow
    from pyarrow import ipc

    pieces: dict[str, list[np.ndarray]] = {}
    try:
        with pyarrow.memory_map(str(path)) as file:
            reader = _opened(ipc, file)
            columns = columns_of(reader.schema, selection.asks_for, path)
            parts = (pyarrow.Table.from_batches([batch]) for batch in _batches(reader))
            for part in chain([reader.schema.empty_table()], parts):
                check_size(part.num_rows * max(len(columns.readable), 1), str(path))
                for name, values in arrays_of(part, columns.readable, path, columns.unusable).items():
                    pieces.setdefault(name, []).append(values)
                check_size(sum(piece.size for parts in pieces.values() for piece in parts), str(path))
            arrays = joined(pieces, columns.unusable, str(path))
    except (pyarrow.ArrowException, OSError, ValueError, KeyError, OverflowError) as error:
        reason = " ".join(str(error).split())[:200]
        raise InputError(f"is not a Feather or Arrow file: {reason}", where=str(path)) from None
    return table_of(arrays, columns, str(path))


def _opened(ipc: Any, file: Any) -> Any:
    """A reader of the file format, or else of the stream's."""
    import pyarrow

    try:
        return ipc.open_file(file)
    except pyarrow.ArrowInvalid:
        file.seek(0)
        return ipc.open_stream(file)


def _batches(reader: Any) -> Iterator[Any]:
    if hasattr(reader, "num_record_batches"):
        yield from (reader.get_batch(index) for index in range(reader.num_record_batches))
    else:
        yield from reader


def joined(pieces: dict[str, list[np.ndarray]], unusable: dict[str, InputError], source: str) -> dict[str, np.ndarray]:
    """Whole columns from those of consecutive parts; lists that differ in length between parts go to `unusable`.

    Parts are taken out of `pieces` as they are copied, so that they need no memory beside the whole columns.
    """
    columns: dict[str, np.ndarray] = {}
    for name in list(pieces):
        parts = pieces.pop(name)
        width = max((part.shape[1] for part in parts if part.ndim == 2), default=0)
        # A part without any list says nothing of their length.
        parts = [np.full((len(p), width), np.nan) if p.ndim == 2 and p.shape[1] == 0 else p for p in parts]
        if len({part.shape[1:] for part in parts}) > 1:
            unusable[name] = not_numeric(name, source, "its lists differ in length")
        elif name not in unusable:
            columns[name] = np.concatenate(parts)
    return columns
