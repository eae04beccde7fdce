"""A log as it lies in its file: named columns of numbers, before anything is known about a robot."""

from __future__ import annotations

import csv
import math
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, final

import numpy as np

from estexp_jax.errors import InputError, known

if TYPE_CHECKING:
    import pyarrow

_ROWS_AT_A_TIME = 10_000


@final
@dataclass(frozen=True, eq=False)
class Table:
    """The columns of one log file.

    Attributes:
        source: the file, as the user gave it; for messages.
        columns: name to float64 values, (rows,), or (rows, k) where a cell holds a list. No sample is NaN.
        unusable: columns that are no numbers, each with the error to raise if somebody needs it: a log may hold text
            that nobody asks for.
        row_numbers: (rows,) the number under which the user finds each row in the file; None: 1, 2, 3, ...
    """

    source: str
    columns: Mapping[str, np.ndarray]
    unusable: Mapping[str, InputError] = field(default_factory=dict)
    row_numbers: np.ndarray | None = None

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all columns, usable or not."""
        return (*self.columns, *self.unusable)

    def place(self, row: int, column: str) -> str:
        """Where a cell is, for a message: file, row (a CSV's header is row 1) and column.

        Args:
            row: 0-based index into the columns.
            column: the column's name in the file.
        """
        number = row + 1 if self.row_numbers is None else int(self.row_numbers[row])
        return f"{self.source}, row {number}, column '{column}'"

    def column(self, name: str, index: int | None = None) -> np.ndarray:
        """One number a row, (rows,) float64.

        Args:
            name: the column's name in the file.
            index: which value of a list column, from 0.

        Raises:
            InputError: there is no such column, it holds no numbers, or `index` does not fit it.
        """
        if name in self.unusable:
            raise self.unusable[name]
        if name not in self.columns:
            raise InputError(f"no column '{name}'", where=self.source, right=known(self.names))
        values, where = self.columns[name], f"{self.source}, column '{name}'"
        if values.ndim == 1:
            if index is not None:
                raise InputError("has one value a row, so no index", where=where, right="leave `index` out")
            return values
        if index is None or not 0 <= index < values.shape[1]:
            what = f"has {values.shape[1]} values a row" + ("" if index is None else f", none at index {index}")
            raise InputError(what, where=where, right=f"give an index from 0 to {values.shape[1] - 1} in a manifest")
        return values[:, index]


def read_table(path: str | Path) -> Table:
    """Read a log; the format follows the file name's extension: .csv, .npz or .parquet.

    Raises:
        InputError: no such file, an unknown extension, or contents that are not what the extension says.
    """
    path = Path(path)
    if path.is_dir():
        raise InputError("is a folder, not a recording", where=str(path), right="LeRobot data sets are not read yet")
    if not path.is_file():
        raise InputError("no such recording", where=str(path), right="give the path of a log")
    extension = path.suffix.lower()
    if extension == ".mcap":
        raise InputError("MCAP is not read yet", where=str(path), right=f"convert it to one of {', '.join(_READERS)}")
    if extension not in _READERS:
        raise InputError(f"unknown kind of recording '{extension}'", where=str(path), right=known(_READERS))
    try:
        return _READERS[extension](path)
    except OSError as error:
        raise InputError(f"cannot be read: {error}", where=str(path)) from None


def read_csv(path: Path) -> Table:
    """Read a comma-separated file with a header line; empty cells and `nan` are NaN.

    Raises:
        InputError: not UTF-8, not CSV, a column name twice, or a row longer or shorter than the header. A text among
            numbers is kept in `Table.unusable`, with its row.
    """
    reader = None
    try:
        # utf-8-sig: spreadsheets put a byte order mark in front, which would become part of the first name.
        with path.open(newline="", encoding="utf-8-sig") as stream:
            reader = csv.reader(stream, strict=True)
            header = _header(next(reader, []), path)
            return _csv_table(header, _csv_rows(reader, len(header), path), path)
    except UnicodeDecodeError as error:
        raise InputError(f"is not UTF-8 text (byte {error.start})", where=str(path), right="save it as UTF-8") from None
    except csv.Error as error:
        line = reader.line_num if reader else 1
        raise InputError(f"is not well-formed CSV: {error}", where=f"{path}, row {line}") from None


def _header(cells: Sequence[str], path: Path) -> list[str]:
    names, where = [cell.strip() for cell in cells], f"{path}, row 1"
    if not any(names):
        raise InputError("has no header", where=where, right="the first line names the columns")
    if len(names) == 1 and (";" in names[0] or "\t" in names[0]):
        raise InputError("columns are not separated by commas", where=where, right="save it comma-separated")
    for name in names:
        if name and names.count(name) > 1:
            raise InputError(f"two columns are called '{name}'", where=where, right="each name once")
    return names


def _csv_rows(reader: Any, width: int, path: Path) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of each row; blank lines are passed over."""
    for cells in reader:
        if not cells:
            continue
        if len(cells) != width:
            what, where = f"{len(cells)} cells under a header of {width} columns", f"{path}, row {reader.line_num}"
            raise InputError(what, where=where, right="one cell a column, empty if no sample")
        yield reader.line_num, cells


def _csv_table(header: Sequence[str], rows: Iterator[tuple[int, list[str]]], path: Path) -> Table:
    parts: dict[str, list[np.ndarray]] = {name: [] for name in header if name}
    unusable: dict[str, InputError] = {}
    lines: list[int] = []
    while chunk := list(islice(rows, _ROWS_AT_A_TIME)):
        for name, cells in zip(header, zip(*(cells for _, cells in chunk), strict=True), strict=True):
            if not name or name in unusable:
                continue
            values, text = _numbers(cells)
            parts[name].append(values)
            if text is not None:
                where = f"{path}, row {chunk[text][0]}, column '{name}'"
                right = "a number, or an empty cell for no sample"
                unusable[name] = InputError(f"'{cells[text]}' is not a number", where=where, right=right)
        lines += [line for line, _ in chunk]
    columns = {name: np.concatenate([np.empty(0), *parts[name]]) for name in parts if name not in unusable}
    return Table(str(path), columns, unusable, np.array(lines, dtype=np.int64))


def _numbers(cells: Sequence[str]) -> tuple[np.ndarray, int | None]:
    """The cells as numbers, and the index of the first one that is none (the values end there)."""
    values: list[float] = []
    for index, cell in enumerate(cells):
        stripped = cell.strip()
        try:
            values.append(float(stripped) if stripped else math.nan)
        except ValueError:
            return np.array(values), index
    return np.array(values, dtype=np.float64), None


def read_npz(path: Path) -> Table:
    """Read a NumPy archive with one array a column, (rows,) or (rows, k). Pickled objects are refused.

    Raises:
        InputError: not a NumPy archive.
    """
    columns: dict[str, np.ndarray] = {}
    unusable: dict[str, InputError] = {}
    if not zipfile.is_zipfile(path):
        raise InputError("is not a NumPy .npz archive", where=str(path), right="write it with numpy.savez")
    with np.load(path, allow_pickle=False) as archive:
        for name in archive.files:
            try:
                columns[name] = _number_array(np.asarray(archive[name]))
            except (ValueError, EOFError, zipfile.BadZipFile) as error:
                unusable[name] = InputError(f"is no column: {error}", where=f"{path}, column '{name}'")
    return Table(str(path), columns, unusable)


def _number_array(values: np.ndarray) -> np.ndarray:
    if values.dtype.kind not in "fiub":
        raise ValueError(f"it holds {values.dtype}, not numbers")
    if values.ndim not in (1, 2):
        raise ValueError(f"its shape is {values.shape}, not (rows,) or (rows, values)")
    return values.astype(np.float64)


def read_parquet(path: Path) -> Table:
    """Read a Parquet file; list columns of one length become (rows, k). Nulls are NaN.

    Raises:
        InputError: not a Parquet file.
    """
    import pyarrow
    from pyarrow import parquet

    try:
        table = parquet.read_table(path, memory_map=False)
    except pyarrow.ArrowException as error:
        raise InputError(f"is not a Parquet file: {error}", where=str(path)) from None
    columns: dict[str, np.ndarray] = {}
    unusable: dict[str, InputError] = {}
    for name in dict.fromkeys(table.column_names):
        try:
            columns[name] = _arrow_numbers(table.column(name).combine_chunks())
        except (ValueError, KeyError) as error:
            unusable[name] = InputError(f"is no column of numbers: {error}", where=f"{path}, column '{name}'")
    return Table(str(path), columns, unusable)


def _arrow_numbers(values: pyarrow.Array) -> np.ndarray:
    import pyarrow

    kind = values.type
    if pyarrow.types.is_list(kind) or pyarrow.types.is_large_list(kind) or pyarrow.types.is_fixed_size_list(kind):
        return _lists_of_numbers(values.to_pylist())
    is_number = pyarrow.types.is_integer(kind) or pyarrow.types.is_floating(kind) or pyarrow.types.is_null(kind)
    if not (is_number or pyarrow.types.is_boolean(kind) or pyarrow.types.is_decimal(kind)):
        raise ValueError(f"it holds {kind}")
    return np.array(values.cast(pyarrow.float64(), safe=False).to_numpy(zero_copy_only=False), dtype=np.float64)


def _lists_of_numbers(rows: list[list[Any] | None]) -> np.ndarray:
    if len({len(row) if row is not None else None for row in rows}) != 1:
        raise ValueError("its lists differ in length")
    try:
        return _number_array(np.array(rows, dtype=np.float64))
    except TypeError:
        raise ValueError("its lists hold no numbers") from None


_READERS: Mapping[str, Callable[[Path], Table]] = {".csv": read_csv, ".npz": read_npz, ".parquet": read_parquet}
