"""How a log's own columns become ours: renamed, scaled, shifted, picked from a list, or a constant."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.errors import InputError, abbreviated, known
from estexp_jax.recordings.table import CLOCKS, Table

UNITS: Mapping[str, float] = {
    "rad": 1.0,
    "mrad": 1e-3,
    "deg": math.pi / 180.0,
    "turn": 2.0 * math.pi,
    "rad/s": 1.0,
    "deg/s": math.pi / 180.0,
    "rpm": 2.0 * math.pi / 60.0,
    "s": 1.0,
    "ms": 1e-3,
    "us": 1e-6,
    "ns": 1e-9,
    "m": 1.0,
    "cm": 1e-2,
    "mm": 1e-3,
}
"""Units that a manifest may name, each with its factor to SI."""

LARGEST = 1e30
"""Limit of magnitude: above any sensor or clock in any unit, and its square is still finite."""
_KEYS = ("column", "scale", "offset", "unit", "index", "clock", "nanoseconds", "value", "hz")


@final
@dataclass(frozen=True)
class Source:
    """Where one of our columns comes from: ours = scale * theirs + offset, a constant, or a count of rows.

    Attributes:
        column: name in the log; None for a constant.
        scale: factor to SI.
        offset: added after scaling, SI.
        index: which value of a list column, from 0; None for one number a row.
        value: the constant, SI; None for a column.
        clock: of a log of topics: `log`, `publish` or `header`; None: the file's.
        nanoseconds: column with the nanoseconds of a time whose seconds are in `column`; None: there is none.
        hz: of a log without a clock, whose rows are evenly spaced; None: it has one.
        scaled: whether scale or unit were given, which then count more than a unit that the file states.
    """

    column: str | None = None
    scale: float = 1.0
    offset: float = 0.0
    index: int | None = None
    value: float | None = None
    clock: str | None = None
    nanoseconds: str | None = None
    hz: float | None = None
    scaled: bool = False

    def __post_init__(self) -> None:
        if sum(given is not None for given in (self.column, self.value, self.hz)) != 1:
            raise ValueError("a source is a column, a constant, or a rate")

    @property
    def columns(self) -> tuple[str, ...]:
        """The columns of the log that it reads."""
        return tuple(name for name in (self.column, self.nanoseconds) if name is not None)

    def read(self, table: Table, rows: int) -> np.ndarray:
        """The values, one a row of the log; a constant is repeated `rows` times.

        Raises:
            InputError: the log has no such column of numbers, or time stamps were given a unit.
        """
        if self.value is not None:
            return np.full(rows, self.value)
        if self.hz is not None:
            return np.arange(max((len(values) for values in table.columns.values()), default=0)) / self.hz
        column = str(self.column)
        values, scale = table.column(column, self.index), self.scale
        if self.scaled and table.base(column) in table.stamps:
            what, right = "holds time stamps, which need no unit", "leave unit and scale out"
            raise InputError(what, where=f"{table.source}, column '{column}'", right=right)
        if not self.scaled:
            scale *= UNITS.get(table.units.get(table.base(column), ""), 1.0)
        if self.nanoseconds is not None:
            # From the first row on, since seconds since 1970 leave no digits for nanoseconds.
            return (values - values[:1]) + 1e-9 * table.column(self.nanoseconds)
        # An unscaled column stays as it was recorded, to the last bit and the sign of zero.
        if (scale, self.offset) == (1.0, 0.0):
            return values
        with np.errstate(over="ignore", invalid="ignore"):  # `bind_columns` reports an infinite value with its row
            return scale * values + self.offset


def parse_source(entry: object, where: str) -> Source:
    """One entry of a manifest's [columns].

    Args:
        entry: a column's name, a table with `column` and any of `scale`, `offset`, `unit`, `index`, `clock`, or `value`
            alone. With `unit`, scale and offset act on the value already turned into SI. A time may also be `column`
            with `nanoseconds`, or `hz` alone.
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
    alone = [key for key in ("value", "hz") if key in entry]
    if bool(alone) == ("column" in entry) or (alone and len(entry) > 1):
        raise InputError("needs either `column` or `value`", where=where, right="{ value = 0.0 } stands alone")
    if "value" in entry:
        return Source(value=parse_number(entry["value"], f"{where}, value"))
    if "hz" in entry:
        return _even_clock(entry["hz"], where)
    column, index = entry["column"], entry.get("index")
    if not isinstance(column, str):
        raise InputError(f"column is {abbreviated(column)}, not a name", where=where, right="a name in quotes")
    if index is not None and (isinstance(index, bool) or not isinstance(index, int) or not 0 <= index < 2**40):
        raise InputError(f"index is {abbreviated(index)}, not a whole number from 0", where=where)
    scale = parse_number(entry.get("scale", 1.0), f"{where}, scale")
    if "unit" in entry:
        scale *= _unit(entry["unit"], where)
    offset, scaled = parse_number(entry.get("offset", 0.0), f"{where}, offset"), bool({"unit", "scale"} & set(entry))
    clock, nanoseconds = entry.get("clock"), entry.get("nanoseconds")
    if clock is not None and clock not in CLOCKS:
        raise InputError(f"clock is {abbreviated(clock)}", where=where, right=known(CLOCKS))
    if nanoseconds is not None and (not isinstance(nanoseconds, str) or scaled or not where.endswith("'time'")):
        right = 'for time alone, without a unit: { column = "sec", nanoseconds = "nanosec" }'
        raise InputError(f"nanoseconds is {abbreviated(nanoseconds)}", where=where, right=right)
    return Source(column, scale, offset, index, clock=clock, nanoseconds=nanoseconds, scaled=scaled)


def _even_clock(hz: object, where: str) -> Source:
    rate = parse_number(hz, f"{where}, hz")
    if not where.endswith("'time'") or not 1e-3 <= rate <= 1e6:
        raise InputError(f"hz is {rate:g}", where=where, right="for time alone: { hz = 50 }, the rate of the rows")
    return Source(hz=rate)


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
