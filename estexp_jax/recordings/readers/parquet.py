"""Read the numeric columns of Parquet logs, one row group at a time."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Collection, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.recordings.table import Selection, Table, check_size, check_width

if TYPE_CHECKING:
    import pyarrow
    from pyarrow import parquet

EPISODE = "episode_index"
"""The column of a LeRobot data set that holds each row's episode."""
_MOST_META_BYTES = 16 * 2**20


def read_parquet(path: Path, selection: Selection) -> Table:
    """Read a Parquet file; list columns of one length become (rows, k). Nulls are NaN.

    A file of a LeRobot data set holds several episodes, one of which is the recording. Values of list columns are named
    as in `meta/info.json` in one of the folders above.

    Raises:
        InputError: the file is not Parquet or too large, or the episode does not exist or was not chosen among several.
    """
    columns, unusable = read_columns([path], selection.episode, str(path))
    label = "" if selection.episode is None else f"{path.stem}_episode_{selection.episode}.parquet"
    if selection.episode is None and EPISODE in columns and len(np.unique(columns[EPISODE])) > 1:
        raise InputError("holds several episodes", where=str(path), right=episodes(np.unique(columns[EPISODE])))
    folder = next((p for p in path.resolve().parents[:4] if (p / "meta" / "info.json").is_file()), None)
    names = {} if folder is None or EPISODE not in columns else part_names(read_info(folder), columns)
    return Table(str(path), columns, unusable, label=label, parts=names)


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


def part_names(info: Mapping[str, Any], columns: Mapping[str, np.ndarray]) -> dict[str, tuple[str, int]]:
    """Names of the values of list columns: `action.elbow_flex.pos` is `action` at the index given in info.json."""
    parts: dict[str, tuple[str, int]] = {}
    features = info.get("features")
    for column, feature in features.items() if isinstance(features, dict) else ():
        names = feature.get("names") if isinstance(feature, dict) else None
        if isinstance(names, dict):  # { "motors": [...] }
            names = next(iter(names.values()), None)
        if not isinstance(names, list) or column not in columns or columns[column].ndim != 2:
            continue
        if len(names) == columns[column].shape[1]:
            parts |= {f"{column}.{name}": (column, k) for k, name in enumerate(names) if isinstance(name, str)}
    return parts


def read_columns(
    files: Sequence[Path], episode: int | None, source: str, only: Collection[str] | None = None
) -> tuple[dict[str, np.ndarray], dict[str, InputError]]:
    """The numeric columns of consecutive files of one table, and the errors of the other columns.

    Args:
        files: at least one.
        episode: which rows to keep; None: all.
        source: the log, for messages.
        only: columns to read; None: all numeric ones.

    Raises:
        InputError: a file is not Parquet, there is no such episode, or the table is too large.
    """
    import pyarrow

    pieces: dict[str, list[np.ndarray]] = {}
    unusable: dict[str, InputError] = {}
    found_episodes: set[float] = set()
    for path in files:
        try:
            for group in _row_groups(path, episode, unusable, only):
                found_episodes |= set(np.unique(group.get(EPISODE, np.empty(0))).tolist())
                keep = slice(None) if episode is None else group[EPISODE] == episode
                for name, values in group.items():
                    pieces.setdefault(name, []).append(values[keep])
                check_size(sum(piece.size for parts in pieces.values() for piece in parts), source)
        except (pyarrow.ArrowException, OSError, ValueError, KeyError, OverflowError) as error:
            reason = " ".join(str(error).split())[:200]
            raise InputError(f"is not a Parquet file: {reason}", where=str(path)) from None
    if episode is not None and episode not in found_episodes:
        present = read_columns(files, None, source, (EPISODE,))[0].get(EPISODE, np.empty(0))
        raise InputError(f"has no episode {episode}", where=source, right=episodes(np.unique(present)))
    columns: dict[str, np.ndarray] = {}
    for name, parts in pieces.items():
        if len({part.shape[1:] for part in parts}) > 1:
            unusable[name] = _not_numeric(name, source, "its lists differ in length")
        elif name not in unusable:
            columns[name] = np.concatenate(parts)
    return columns, unusable


def _not_numeric(name: str, source: object, why: str) -> InputError:
    return InputError(f"is no column of numbers: {why}", where=f"{source}, column '{name}'")


def _row_groups(
    path: Path, episode: int | None, unusable: dict[str, InputError], only: Collection[str] | None
) -> Iterator[dict[str, np.ndarray]]:
    """The numeric columns of each row group, except for groups that cannot contain the episode."""
    from pyarrow import parquet

    with parquet.ParquetFile(path, memory_map=False) as file:
        counts = Counter(file.schema_arrow.names)
        check_width(len(counts), str(path))
        readable: list[str] = []
        for field in file.schema_arrow:
            if only is not None and field.name not in only:
                continue
            why = "two columns have this name" if counts[field.name] > 1 else _reason_unreadable(field.type)
            if why:
                unusable.setdefault(field.name, _not_numeric(field.name, path, why))
            else:
                readable.append(field.name)
        if episode is not None and EPISODE not in readable:
            raise InputError("has no episodes", where=str(path), right=f"a LeRobot data set has a column '{EPISODE}'")
        groups = [file.metadata.row_group(index) for index in range(file.num_row_groups)]
        if episode is None:
            check_size(sum(_count_values(group, len(readable)) for group in groups), str(path))
        for index, group in enumerate(groups):
            if episode is None or _may_contain(group, episode):
                check_size(_count_values(group, len(readable)), str(path))
                yield _numeric_columns(file.read_row_group(index, columns=readable), readable, path, unusable)
        if file.num_row_groups == 0:
            yield _numeric_columns(file.schema_arrow.empty_table().select(readable), readable, path, unusable)


def _count_values(group: parquet.RowGroupMetaData, columns: int) -> int:
    """Upper bound of the values in a row group, as its metadata states; -1 if these are invalid."""
    counts = [group.column(k).num_values for k in range(group.num_columns)]
    return max(sum(counts), group.num_rows * columns) if min(counts, default=0) >= 0 <= group.num_rows else -1


def _may_contain(group: parquet.RowGroupMetaData, episode: int) -> bool:
    """Whether a row group may contain the episode, by the minimum and maximum in its statistics, if any."""
    for k in range(group.num_columns):
        column = group.column(k)
        if column.path_in_schema == EPISODE and column.statistics is not None and column.statistics.has_min_max:
            return bool(column.statistics.min <= episode <= column.statistics.max)
    return True


def _reason_unreadable(kind: pyarrow.DataType) -> str:
    """Why a column of this type is not numeric; empty if it is."""
    from pyarrow import types

    if types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind):
        inner = kind.value_type
        return "" if not types.is_nested(inner) and not _reason_unreadable(inner) else f"it holds lists of {inner}"
    number = types.is_integer(kind) or types.is_floating(kind) or types.is_null(kind)
    return "" if number or types.is_boolean(kind) or types.is_decimal(kind) else f"it holds {kind}"


def _numeric_columns(
    table: pyarrow.Table, readable: Sequence[str], path: Path, unusable: dict[str, InputError]
) -> dict[str, np.ndarray]:
    columns: dict[str, np.ndarray] = {}
    for name in readable:
        try:
            columns[name] = _to_numpy(table.column(name).combine_chunks())
        except ValueError as error:
            unusable.setdefault(name, _not_numeric(name, path, str(error)))
    if EPISODE in readable and EPISODE not in columns:
        raise unusable[EPISODE]
    return columns


def _to_numpy(values: Any) -> np.ndarray:
    import pyarrow
    from pyarrow import compute, types

    if not types.is_nested(values.type):
        return np.array(values.cast(pyarrow.float64(), safe=False).to_numpy(zero_copy_only=False), dtype=np.float64)
    lengths = compute.call_function("list_value_length", [values])
    width = compute.call_function("min_max", [lengths]).as_py()
    if values.null_count or width["min"] != width["max"]:
        raise ValueError("its lists differ in length")
    flat = _to_numpy(values.flatten())
    return flat.reshape(len(values), (width["min"] or 0))
