"""How a text log is written: what separates its columns, where its header is, which lines are none of its rows."""

from __future__ import annotations

import csv
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

from estexp_jax.errors import InputError
from estexp_jax.recordings.columns import UNITS
from estexp_jax.recordings.readers.stamps import parsed_stamps

ABSENT = frozenset({"", "na", "n/a", "nan", "null", "none", "-", "--"})
"""Cells, in small letters, that mean no sample."""
SWITCHES = {"true": 1.0, "false": 0.0}
"""Cells, in small letters, that mean on and off."""
COMMENTS = ("#", "%", "//")
"""How lines begin that are none of the table."""
_SEPARATORS = (",", ";", "\t")
_MOST_LINES, _LONGEST = 20, 2**24
_MOST_LEVELS = 4
"""Lines of a header."""
_UNITS: Mapping[str, str] = {
    **{unit: unit for unit in UNITS},
    **dict.fromkeys(("turns", "rev", "revs", "revolutions"), "turn"),
    **dict.fromkeys(("°", "degree", "degrees"), "deg"),
    **dict.fromkeys(("°/s", "degrees/s", "dps"), "deg/s"),
    **dict.fromkeys(("µs", "\u03bcs", "usec", "microseconds"), "us"),
    **{"sec": "s", "seconds": "s", "msec": "ms", "milliseconds": "ms", "nsec": "ns", "nanoseconds": "ns"},
}


@final
@dataclass(frozen=True)
class CsvForm:
    """The form of one file.

    Attributes:
        separator: of the cells.
        names: of the columns, as the header has them; empty ones are no columns.
        skipped: how many lines come before the first row of cells.
        header_line: number of the header's line, from 1.
    """

    separator: str
    names: tuple[str, ...]
    skipped: int
    header_line: int


def form_of(path: Path) -> CsvForm:
    """Find out the form from the beginning of a file.

    Raises:
        InputError: it has no header.
        UnicodeDecodeError: it is not UTF-8.
    """
    lines, table = _head(path)
    if not table:
        raise InputError("has no header", where=f"{path}, row 1", right="the first line names the columns")
    first, rows = table[0], [lines[k] for k in table]
    where = f"{path}, row {first + 1}"
    separator = "\t" if path.suffix.lower() == ".tsv" else _separator(rows)
    _refuse_spaces(rows, separator, where)
    names, height = _header(lines[first:], separator)
    if height == 1:
        names, height = _with_levels(names, [_cells(row, separator) for row in rows[1:]])
    if not any(names):
        raise InputError("has no header", where=where, right="the first line names the columns")
    comment = max((k for k in range(first) if lines[k].strip()), default=None)
    if comment is not None and any(name and _is_value(name) for name in names):  # as of numpy.savetxt, rostopic echo -p
        named = _cells(re.sub(r"^\s*(#+|%+|//)", "", lines[comment]), separator)
        if len(named) == len(names) and not any(_is_value(name) for name in named):
            return CsvForm(separator, named, first, comment + 1)
    if not all(_is_value(name) for name in names):
        return CsvForm(separator, names, first + height, first + 1)
    right = "the first line names the columns"
    raise InputError(f"has no header: the first line holds '{lines[first].strip()[:80]}'", where=where, right=right)


def _header(lines: Sequence[str], separator: str) -> tuple[tuple[str, ...], int]:
    """The cells of the first row, and how many lines it takes: a quoted name may hold line breaks."""
    reader = csv.reader(lines, delimiter=separator)
    try:
        cells = next(reader, [])
    except csv.Error:
        return _cells(lines[0], separator), 1
    return tuple(cell.strip() for cell in cells), reader.line_num


def _with_levels(names: tuple[str, ...], rows: Sequence[Sequence[str]]) -> tuple[tuple[str, ...], int]:
    """Names of a header in several lines, joined, and how many these are: pandas writes a level of columns in each.

    The last of them may hold the name of the index alone.
    """
    given = [name for name in names if name]
    if len(set(given)) == len(given):
        return names, 1
    height = 1
    for cells in rows[: _MOST_LEVELS - 1]:
        units = units_in(cells, names)
        if len(cells) != len(names) or units is None or any(units.values()):
            break
        height += 1
        if not any(cells[1:]):
            return (cells[0], *names[1:]), height
        names = tuple(".".join(filter(None, pair)) for pair in zip(names, cells, strict=True))
    return names, height


def _refuse_spaces(rows: Sequence[str], separator: str, where: str) -> None:
    """Refuse a table whose cells are separated by spaces, in which no name is one cell for sure.

    Raises:
        InputError: it is one.
    """
    words = [row.split() for row in rows]
    if len(_cells(rows[0], separator)) > 1 or len(words) < 2 or len({len(each) for each in words}) > 1:
        return
    if len(words[0]) > 1 and all(_is_value(cell) for each in words[1:] for cell in each):
        right = r"commas, semicolons or tabs: pandas.read_csv(path, sep=r'\s+').to_csv(path, index=False) writes them"
        raise InputError("its cells are separated by spaces", where=where, right=right)


def _head(path: Path) -> tuple[list[str], list[int]]:
    """The first lines of a file, and which of them are of the table, its header first."""
    lines, table = list[str](), list[int]()
    with path.open(newline="", encoding="utf-8-sig") as stream:
        while len(table) < _MOST_LINES and (line := stream.readline(_LONGEST)):
            if line.strip() and not is_comment(line):
                table.append(len(lines))
            lines.append(line)
            if len(lines) > 100 * _MOST_LINES and not table:
                break
    return lines, table


def is_comment(line: str) -> bool:
    """Whether a line is a comment, or tells a spreadsheet the separator."""
    return line.lstrip().startswith(COMMENTS) or bool(re.fullmatch(r"sep=.?\s*", line))


def units_in(cells: Sequence[str], names: Sequence[str]) -> dict[str, str] | None:
    """The units in a row below the header, by column, those that a manifest knows; None if it is a row of values."""
    stripped = [cell.strip() for cell in cells]
    if not any(stripped) or any(_is_value(cell) for cell in stripped if cell):
        return None
    pairs = zip(names, stripped, strict=False)
    return {name: unit for name, cell in pairs if name and (unit := _UNITS.get(cell.strip("[]() ").lower()))}


def units_of(names: Sequence[str]) -> dict[str, str]:
    """The units that names such as `knee [deg]` state."""
    found: dict[str, str] = {}
    for name in names:
        match = re.search(r"[\[(]([^\[\]()]+)[\])]$", name)
        if match and (unit := _UNITS.get(match[1].strip().lower())):
            found[name] = unit
    return found


def _is_value(cell: str) -> bool:
    """Whether a cell is a number, a switch, a time stamp, or says that there is no sample."""
    if not cell or cell.lower() in SWITCHES or (cell.lower() in ABSENT):
        return True
    try:
        float(cell.replace(",", ".") if cell.count(",") == 1 else cell)
    except ValueError:
        return parsed_stamps([cell]) is not None
    return True


def _separator(lines: Sequence[str]) -> str:
    """The separator by which the first lines have most cells, alike in most of them."""
    best, most = ",", (0.0, 1)
    for separator in _SEPARATORS:
        widths = [len(_cells(line, separator)) for line in lines]
        alike = sum(width == widths[0] for width in widths) / len(widths)
        if widths[0] > 1 and (alike > 0.5, widths[0]) > most:
            best, most = separator, (alike > 0.5, widths[0])
    return best


def _cells(line: str, separator: str) -> tuple[str, ...]:
    try:
        return tuple(cell.strip() for cell in next(csv.reader([line.rstrip("\r\n")], delimiter=separator), []))
    except csv.Error:
        return (line.strip(),)
