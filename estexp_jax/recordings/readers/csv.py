"""Read comma-separated logs in chunks of rows."""

from __future__ import annotations

import csv
import math
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.recordings.table import Selection, Table, check_size, check_width

_ROWS_AT_A_TIME = 10_000


def read_csv(path: Path, selection: Selection) -> Table:
    """Read a comma-separated file with a header line; empty cells and `nan` are NaN.

    Raises:
        InputError: the file is not UTF-8 or not CSV, a column name occurs twice, or a row differs in length from the
            header. A column with text in it goes to `Table.unusable`, with the row.
    """
    reader = None
    try:
        # utf-8-sig: spreadsheets put a byte order mark in front, which would become part of the first name.
        with path.open(newline="", encoding="utf-8-sig") as stream:
            reader = csv.reader(stream, strict=True)
            header = _header(next(reader, []), path)
            return _table(header, _rows(reader, len(header), path), path)
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
    check_width(len(names), where)
    for name, count in Counter(names).items():
        if name and count > 1:
            raise InputError(f"two columns are called '{name}'", where=where, right="each name once")
    return names


def _rows(reader: Any, width: int, path: Path) -> Iterator[tuple[int, list[str]]]:
    """Line number and cells of each row; blank lines are skipped."""
    for cells in reader:
        if not cells:
            continue
        if len(cells) != width:
            what, where = f"{len(cells)} cells under a header of {width} columns", f"{path}, row {reader.line_num}"
            raise InputError(what, where=where, right="one cell a column, empty if no sample")
        yield reader.line_num, cells


def _table(header: Sequence[str], rows: Iterator[tuple[int, list[str]]], path: Path) -> Table:
    parts: dict[str, list[np.ndarray]] = {name: [] for name in header if name}
    unusable: dict[str, InputError] = {}
    lines = [np.empty(0, dtype=np.int64)]
    count = 0
    while chunk := list(islice(rows, _ROWS_AT_A_TIME)):
        count += len(chunk)
        check_size(count * len(header), str(path))
        for name, cells in zip(header, zip(*(cells for _, cells in chunk), strict=True), strict=True):
            if not name or name in unusable:
                continue
            values, text = _parse_numbers(cells)
            parts[name].append(values)
            if text is not None:
                where = f"{path}, row {chunk[text][0]}, column '{name}'"
                right = "a number, or an empty cell for no sample"
                unusable[name] = InputError(f"'{cells[text][:80]}' is not a number", where=where, right=right)
        lines.append(np.array([line for line, _ in chunk], dtype=np.int64))
    columns = {name: np.concatenate([np.empty(0), *parts[name]]) for name in parts if name not in unusable}
    return Table(str(path), columns, unusable, np.concatenate(lines))


def _parse_numbers(cells: Sequence[str]) -> tuple[np.ndarray, int | None]:
    """The cells as numbers, up to the first that is not a number, and the index of that one."""
    values: list[float] = []
    for index, cell in enumerate(cells):
        stripped = cell.strip()
        try:
            values.append(float(stripped) if stripped else math.nan)
        except ValueError:
            return np.array(values), index
    return np.array(values, dtype=np.float64), None
