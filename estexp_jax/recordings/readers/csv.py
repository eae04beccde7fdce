"""Read text logs, CSV and its relatives, in chunks of rows."""

from __future__ import annotations

import csv
import os
import re
from collections import Counter, deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from itertools import islice
from pathlib import Path
from typing import Any, final

import numpy as np

from estexp_jax.errors import InputError, listing
from estexp_jax.recordings.readers.csv_column import TextColumn
from estexp_jax.recordings.readers.csv_form import CsvForm, form_of, is_comment, units_in, units_of
from estexp_jax.recordings.readers.stamps import is_stamp, seconds
from estexp_jax.recordings.table import Selection, Table, check_size, check_width

_ROWS_AT_A_TIME, _FEW_ROWS = 10_000, 3


@final
@dataclass(eq=False)
class _Lines:
    """The rows of a file, and what was noticed on the way.

    Attributes:
        form: of the file.
        path: the file.
        units: by column, from a line of units below the header.
        restarts: rows, from 0, before which the header was repeated.
        notes: remarks for the user.
        last_cells: of the rows before.
    """

    form: CsvForm
    path: Path
    units: dict[str, str] = field(default_factory=dict)
    restarts: list[int] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    last_cells: deque[str] = field(default_factory=lambda: deque(maxlen=50))

    def rows(self, reader: Any) -> Iterator[tuple[int, list[str]]]:
        """Line number and cells of each row; blank lines, comments and repeated headers are left out."""
        count, width, header = 0, len(self.form.names), list(self.form.names)
        may_be_units, before = True, list[str]()
        for cells, line, is_last in self._with_last(reader):
            if not cells or (is_comment(cells[0]) and cells != before):
                continue
            if [cell.strip() for cell in cells] == header:
                self.restarts.append(count)
                may_be_units = True
                continue
            if may_be_units and (units := units_in(cells, self.form.names)) is not None:
                self._note_units(units, line)
                may_be_units = False
                continue
            may_be_units = False
            if is_last and self._is_cut(cells, before):
                self.notes.append(f"the file ends in the middle of row {line}, which is left out")
                return
            yield line, self._fitting(cells, width, line)
            count, before = count + 1, cells
            self.last_cells.append(cells[-1])

    def _with_last(self, reader: Any) -> Iterator[tuple[list[str], int, bool]]:
        """The rows, the number of their line, and whether each is one that the file ends with, without a line break."""
        open_end = _ends_open(self.path)
        last = None
        try:
            for cells in reader:
                if last is not None:
                    yield *last, False
                last = cells, reader.line_num + self.form.skipped
        except csv.Error as error:
            if not (open_end and "unexpected end of data" in str(error)):
                raise
            self.notes.append("the file ends in the middle of a row, which is left out")
        if last is not None:
            yield *last, open_end

    def _is_cut(self, cells: Sequence[str], before: Sequence[str]) -> bool:
        """Whether the last row was cut, also within its last cell: half a number looks like another number."""
        if len(cells) < (len(before) or len(self.form.names)):
            return True
        if not before:
            return False
        if len(self.last_cells) <= _FEW_ROWS:
            return len(cells[-1].strip()) < len(before[-1].strip())
        digits = {len(cell.strip().replace(",", ".").partition(".")[2]) for cell in (*self.last_cells, cells[-1])}
        return len(digits) > 1 or bool(re.search(r"[eE]", cells[-1]))  # written with as many digits always, it is whole

    def _fitting(self, cells: list[str], width: int, line: int) -> list[str]:
        """The cells of a row, one a column; a separator more or less at its end is no matter."""
        if len(cells) == width + 1 and not cells[-1].strip():
            return cells[:-1]
        if len(cells) == width - 1 and not self.form.names[-1]:
            return [*cells, ""]
        if len(cells) != width:
            what, where = f"{len(cells)} cells under a header of {width} columns", f"{self.path}, row {line}"
            raise InputError(what, where=where, right="one cell a column, empty if no sample")
        return cells

    def _note_units(self, units: dict[str, str], line: int) -> None:
        if not self.restarts:
            self.units |= units
            listed = ", ".join(f"{name} in {unit}" for name, unit in units.items())
            self.notes.append(f"row {line} holds units{': ' if listed else ''}{listed}")


def read_csv(path: Path, selection: Selection) -> Table:
    """Read a text log with a header line: separated by commas, semicolons (decimal commas too) or tabs.

    Empty cells, `nan` and `NA` are NaN, `True` is 1, ISO time stamps are s from the first one on. Comments, a line of
    units, repeated headers and a last row that was cut are no rows.

    Raises:
        InputError: the file is not UTF-8 or not CSV, has no header, or a row differs in length from the header. A
            column with text in it, or with another's name, goes to `Table.unusable`.
    """
    reader, form = None, None
    try:
        form = form_of(path)
        check_width(len(form.names), f"{path}, row {form.header_line}")
        # utf-8-sig: spreadsheets put a byte order mark in front, which would become part of the first name.
        with path.open(newline="", encoding="utf-8-sig") as stream:
            for _ in range(form.skipped):
                stream.readline()
            reader = csv.reader(stream, strict=True, delimiter=form.separator)
            return _table(_Lines(form, path), reader, path)
    except UnicodeDecodeError as error:
        raise InputError(f"is not UTF-8 text (byte {error.start})", where=str(path), right="save it as UTF-8") from None
    except csv.Error as error:
        line = (reader.line_num if reader else 1) + (form.skipped if form else 0)
        raise InputError(f"is not well-formed CSV: {error}", where=f"{path}, row {line}") from None


def _ends_open(path: Path) -> bool:
    """Whether a file ends without a line break, as one that was cut does."""
    with path.open("rb") as stream:
        if not stream.seek(0, os.SEEK_END):
            return False
        stream.seek(-1, os.SEEK_END)
        return stream.read(1) not in (b"\n", b"\r")


def _table(lines: _Lines, reader: Any, path: Path) -> Table:
    names, where = lines.form.names, f"{path}, row {lines.form.header_line}"
    twice = {name for name, count in Counter(names).items() if name and count > 1}
    unusable = {
        name: InputError(f"two columns are called '{name}'", where=where, right="each name once") for name in twice
    }
    columns = [TextColumn(name) for name in names]
    row_numbers, count, rows = [np.empty(0, dtype=np.int64)], 0, lines.rows(reader)
    while chunk := list(islice(rows, _ROWS_AT_A_TIME)):
        count += len(chunk)
        check_size(count * len(names), str(path))
        of_chunk = [line for line, _ in chunk]
        for column, cells in zip(columns, zip(*(cells for _, cells in chunk), strict=True), strict=True):
            if column.name and column.name not in twice:
                column.add(cells, of_chunk, path, lines.form.separator != ",")
        row_numbers.append(np.array(of_chunk, dtype=np.int64))
    unusable |= {column.name: column.error for column in columns if column.error is not None}
    arrays = {c.name: c.values() for c in columns if c.name and c.name not in unusable}
    stamps = frozenset(name for name, values in arrays.items() if is_stamp(values))
    arrays = {name: seconds(values) if name in stamps else values for name, values in arrays.items()}
    if twice:
        lines.notes.append(f"two columns have one name, so neither is read: {listing(sorted(twice))}")
    return Table(
        str(path),
        arrays,
        unusable,
        np.concatenate(row_numbers),
        notes=tuple(lines.notes),
        units=units_of(names) | lines.units,
        stamps=stamps,
        restarts=tuple(lines.restarts),
    )
