"""Read the numeric columns of Parquet logs, one row group at a time."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.arrow import (
    ArrowColumns,
    arrays_of,
    columns_of,
    empty_column,
    fill,
    is_plain,
    joined,
    table_of,
)
from estexp_jax.recordings.table import Selection, Table, check_size

if TYPE_CHECKING:
    from pyarrow import parquet

EPISODE = "episode_index"
"""The column of a LeRobot data set that holds each row's episode."""
_MOST_META_BYTES = 16 * 2**20
_BATCH = 65_536
"""Rows that are decoded at a time."""


def read_parquet(path: Path, selection: Selection) -> Table:
    """Read a Parquet file; list columns of one length become (rows, k). Nulls are NaN.

    A file of a LeRobot data set holds several episodes, one of which is the recording. Values of list columns are named
    as in `meta/info.json` in one of the folders above.

    Raises:
        InputError: the file is not Parquet or too large, or the episode does not exist or was not chosen among several.
    """
    read = _read_plain(path, selection.asks_for) if selection.episode is None else None
    arrays, columns = read or read_columns([path], selection.episode, str(path), selection.asks_for)
    label = "" if selection.episode is None else f"{path.stem}_episode_{selection.episode}.parquet"
    if selection.episode is None and EPISODE in arrays and len(np.unique(arrays[EPISODE])) > 1:
        raise InputError("holds several episodes", where=str(path), right=episodes(np.unique(arrays[EPISODE])))
    folder = next((p for p in path.resolve().parents[:4] if (p / "meta" / "info.json").is_file()), None)
    names = {} if folder is None or EPISODE not in arrays else part_names(read_info(folder), arrays)
    return table_of(arrays, columns, str(path), label=label, parts=names)


def _read_plain(path: Path, wanted: Callable[[str], bool]) -> tuple[dict[str, np.ndarray], ArrowColumns] | None:
    """The columns of a file of plain numbers, each batch put in its place at once; None where there are others.

    Raises:
        InputError: the file is not Parquet, or too large.
    """
    import pyarrow
    from pyarrow import parquet

    try:
        with parquet.ParquetFile(path, memory_map=False, pre_buffer=False) as file:
            schema, rows = file.schema_arrow, file.metadata.num_rows
            columns = columns_of(schema, lambda name: name == EPISODE or wanted(name), path)
            names = list(columns.readable)
            if not all(name in schema.names and is_plain(schema.field(name).type) for name in names):
                return None
            check_size(
                sum(_count_values(file.metadata.row_group(k), columns) for k in range(file.num_row_groups)), str(path)
            )
            check_size(rows * max(len(names), 1), str(path))
            arrays = {name: empty_column(rows) for name in names}
            first = 0
            for batch in file.iter_batches(batch_size=_BATCH, columns=names, use_threads=False):
                for name, values in zip(batch.schema.names, batch.columns, strict=True):
                    fill(arrays[name][first : first + batch.num_rows], values)
                first += batch.num_rows
            if first != rows:
                raise ValueError(f"it holds {first:,} rows instead of {rows:,}")
    except (pyarrow.ArrowException, OSError, ValueError, KeyError, OverflowError) as error:
        raise _no_parquet(path, error) from None
    return arrays, columns


def _no_parquet(path: Path, error: Exception) -> InputError:
    """The error to raise where pyarrow cannot read a file; without what stands at its end nothing can."""
    what = f"is not a Parquet file: {' '.join(str(error).split())[:200]}"
    return InputError(what, where=str(path), right="a file that was written to its end; a cut one cannot be read")


def episodes(existing: Sequence[float] | np.ndarray) -> str:
    """Advice for choosing an episode, with those that exist."""
    listed = ", ".join(f"{value:g}" for value in existing[:20]) + (", ..." if len(existing) > 20 else "")
    return f"choose one with `episode = 0` under [[recording]] in a manifest; there are: {listed or 'none'}"


def read_info(folder: Path) -> dict[str, Any]:
    """The description of a LeRobot data set, `meta/info.json`.

    Raises:
        InputError: it is not a JSON object, or too large.
    """
    path = folder / "meta" / "info.json"
    try:
        if path.stat().st_size > _MOST_META_BYTES:
            raise InputError(f"is {path.stat().st_size:,} bytes long", where=str(path), right="a short description")
        info = json.loads(path.read_text(encoding="utf-8"))
    except (ValueError, RecursionError) as error:
        raise InputError(f"is not JSON: {error}", where=str(path)) from None
    if not isinstance(info, dict):
        raise InputError("is no JSON object", where=str(path), right="a data set's description")
    return info


def part_names(info: Mapping[str, Any], columns: Mapping[str, np.ndarray]) -> dict[str, tuple[str, int | None]]:
    """Names of the values of list columns: `action.elbow_flex.pos` is `action` at the index given in info.json.

    A list of one value is stored as a plain number, which has no index.
    """
    parts: dict[str, tuple[str, int | None]] = {}
    features = info.get("features")
    for column, feature in features.items() if isinstance(features, dict) else ():
        names = feature.get("names") if isinstance(feature, dict) else None
        if isinstance(names, dict):  # { "motors": [...] }
            names = next(iter(names.values()), None)
        if not isinstance(names, list) or column not in columns or columns[column].ndim > 2:
            continue
        single = columns[column].ndim == 1
        if len(names) == (1 if single else columns[column].shape[1]):
            indices = [None] if single else range(len(names))
            pairs = zip(names, indices, strict=True)
            parts |= {f"{column}.{name}": (column, k) for name, k in pairs if isinstance(name, str)}
    return parts


def read_columns(
    files: Sequence[Path], episode: int | None, source: str, wanted: Callable[[str], bool]
) -> tuple[dict[str, np.ndarray], ArrowColumns]:
    """The numeric columns of consecutive files of one table, and what became of the others.

    Args:
        files: at least one.
        episode: which rows to keep; None: all.
        source: the log, for messages.
        wanted: whether a column of this name is read; that of the episode is in any case.

    Raises:
        InputError: a file is not Parquet, there is no such episode, or the table is too large.
    """
    import pyarrow

    pieces: dict[str, list[np.ndarray]] = {}
    unusable: dict[str, InputError] = {}
    unread: dict[str, None] = {}
    found_episodes: set[float] = set()
    for path in files:
        try:
            for group, columns in _row_groups(path, episode, unusable, wanted):
                unread |= dict.fromkeys(columns.unread)
                found_episodes |= set(np.unique(group.get(EPISODE, np.empty(0))).tolist())
                keep = slice(None) if episode is None else group[EPISODE] == episode
                for name, values in group.items():
                    pieces.setdefault(name, []).append(values[keep])
                check_size(sum(piece.size for parts in pieces.values() for piece in parts), source)
        except (pyarrow.ArrowException, OSError, ValueError, KeyError, OverflowError) as error:
            raise _no_parquet(path, error) from None
    if episode is not None and episode not in found_episodes:
        present = read_columns(files, None, source, _is_episode)[0].get(EPISODE, np.empty(0))
        raise InputError(f"has no episode {episode}", where=source, right=episodes(np.unique(present)))
    arrays = joined(pieces, unusable, source)
    return arrays, ArrowColumns(tuple(arrays), unusable, tuple(unread))


def _is_episode(name: str) -> bool:
    return name == EPISODE


def _row_groups(
    path: Path, episode: int | None, unusable: dict[str, InputError], wanted: Callable[[str], bool]
) -> Iterator[tuple[dict[str, np.ndarray], ArrowColumns]]:
    """The numeric columns of each row group, except for groups that cannot contain the episode."""
    from pyarrow import parquet

    with parquet.ParquetFile(path, memory_map=False) as file:
        columns = columns_of(file.schema_arrow, lambda name: name == EPISODE or wanted(name), path)
        for name, error in columns.unusable.items():
            unusable.setdefault(name, error)
        readable = columns.readable
        if episode is not None and EPISODE not in readable:
            raise InputError("has no episodes", where=str(path), right=f"a LeRobot data set has a column '{EPISODE}'")
        groups = [file.metadata.row_group(index) for index in range(file.num_row_groups)]
        if episode is None:
            check_size(sum(_count_values(group, columns) for group in groups), str(path))
        for index, group in enumerate(groups):
            if episode is None or _may_contain(group, episode):
                check_size(_count_values(group, columns), str(path))
                table = file.read_row_group(index, columns=list(readable))
                yield _with_episode(arrays_of(table, readable, path, unusable), columns, unusable), columns
        if file.num_row_groups == 0:
            yield arrays_of(file.schema_arrow.empty_table(), readable, path, unusable), columns


def _with_episode(
    arrays: dict[str, np.ndarray], columns: ArrowColumns, unusable: Mapping[str, InputError]
) -> dict[str, np.ndarray]:
    if EPISODE in columns.readable and EPISODE not in arrays:
        raise unusable[EPISODE]
    return arrays


def _count_values(group: parquet.RowGroupMetaData, columns: ArrowColumns) -> int:
    """Upper bound of the values read of a row group, as its metadata states; -1 if these are invalid."""
    chunks = [group.column(k) for k in range(group.num_columns)]
    if min((chunk.num_values for chunk in chunks), default=0) < 0 or group.num_rows < 0:
        return -1
    read = [c.num_values for c in chunks if any(f"{c.path_in_schema}.".startswith(f"{n}.") for n in columns.readable)]
    return max(sum(read), group.num_rows * len(columns.readable))


def _may_contain(group: parquet.RowGroupMetaData, episode: int) -> bool:
    """Whether a row group may contain the episode, by the minimum and maximum in its statistics, if any."""
    for k in range(group.num_columns):
        column = group.column(k)
        if column.path_in_schema == EPISODE and column.statistics is not None and column.statistics.has_min_max:
            return bool(column.statistics.min <= episode <= column.statistics.max)
    return True
