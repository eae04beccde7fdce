"""How a log's own columns become ours: renamed, scaled, shifted, picked from a list, or a constant."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.errors import InputError, abbreviated, known
from estexp_jax.recordings.table import Table

UNITS: Mapping[str, float] = {
    "rad": 1.0,
    "deg": math.pi / 180.0,
    "rad/s": 1.0,
    "deg/s": math.pi / 180.0,
    "rpm": 2.0 * math.pi / 60.0,
    "s": 1.0,
    "ms": 1e-3,
    "us": 1e-6,
    "ns": 1e-9,
    "m": 1.0,
    "mm": 1e-3,
}
"""Units that a manifest may name, each with its factor to SI."""

LARGEST = 1e30
"""Limit of magnitude: above any sensor or clock in any unit, and its square is still finite."""
_KEYS = ("column", "scale", "offset", "unit", "index", "value")


@final
@dataclass(frozen=True)
class Source:
    """Where one of our columns comes from: ours = scale * theirs + offset, or a constant.

    Attributes:
        column: name in the log; None for a constant.
        scale: factor to SI.
        offset: added after scaling, SI.
        index: which value of a list column, from 0; None for one number a row.
        value: the constant, SI; None for a column.
    """

    column: str | None = None
    scale: float = 1.0
    offset: float = 0.0
    index: int | None = None
    value: float | None = None

    def __post_init__(self) -> None:
        if (self.column is None) == (self.value is None):
            raise ValueError("a source is either a column or a constant")

    def read(self, table: Table, rows: int) -> np.ndarray:
        """The values, one a row of the log; a constant is repeated `rows` times.

        Raises:
            InputError: the log has no such column of numbers.
        """
        if self.value is not None:
            return np.full(rows, self.value)
        values = table.column(str(self.column), self.index)
        # An unscaled column stays as it was recorded, to the last bit and the sign of zero.
        if (self.scale, self.offset) == (1.0, 0.0):
            return values
        with np.errstate(over="ignore", invalid="ignore"):  # `bind_columns` reports an infinite value with its row
            return self.scale * values + self.offset


def parse_source(entry: object, where: str) -> Source:
    """One entry of a manifest's [columns].

    Args:
        entry: a column's name, a table with `column` and any of `scale`, `offset`, `unit`, `index`, or `value` alone.
            With `unit`, scale and offset act on the value already turned into SI.
        where: the entry's place, for messages.

    Raises:
        InputError: the entry has none of these forms, or one of its keys is unknown or of the wrong type.
    """
    if isinstance(entry, str):
        return Source(column=entry)
    if not isinstance(entry, Mapping):
        right = 'a name "position" or a table { column = "position", scale = 1.0 }'
        raise InputError(f"is {abbreviated(entry)}, not a column", where=where, right=right)
    for key in entry:
        if key not in _KEYS:
            raise InputError(f"unknown key '{key}'", where=where, right=known(_KEYS))
    if ("value" in entry) == ("column" in entry) or ("value" in entry and len(entry) > 1):
        raise InputError("needs either `column` or `value`", where=where, right="{ value = 0.0 } stands alone")
    if "value" in entry:
        return Source(value=parse_number(entry["value"], f"{where}, value"))
    column, index = entry["column"], entry.get("index")
    if not isinstance(column, str):
        raise InputError(f"column is {abbreviated(column)}, not a name", where=where, right="a name in quotes")
    if index is not None and (isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < 2**40):
        raise InputError(f"index is {abbreviated(index)}, not a whole number from 0", where=where)
    scale = parse_number(entry.get("scale", 1.0), f"{where}, scale")
    if "unit" in entry:
        scale *= _unit(entry["unit"], where)
    return Source(column, scale, parse_number(entry.get("offset", 0.0), f"{where}, offset"), index)


def _unit(unit: object, where: str) -> float:
    if not isinstance(unit, str) or unit not in UNITS:
        raise InputError(f"unknown unit {abbreviated(unit)}", where=where, right=f"{known(UNITS)}; else give a scale")
    return UNITS[unit]


def parse_number(value: object, where: str) -> float:
    """A finite number from a manifest.

    Raises:
        InputError: `value` is no number, or not finite.
    """
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) <= sys.float_info.max:
        raise InputError(f"is {abbreviated(value)}, not a finite number", where=where)
    return float(value)


def parse_map(text: str) -> tuple[str, Source]:
    """Our column and its source from an option like `ctrl.servo=goal_position` (ours=theirs).

    Raises:
        InputError: not of that form.
    """
    ours, sign, theirs = (part.strip() for part in text.partition("="))
    if not (ours and sign and theirs):
        right = 'ours=theirs, as in "ctrl.servo=goal_position"'
        raise InputError(f"'{text}' is no mapping", where="--map", right=right)
    return ours, Source(column=theirs)
