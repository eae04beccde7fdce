"""The columns of a log file, before they are bound to a robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import final

import numpy as np

from estexp_jax.errors import InputError, known

MOST_NUMBERS = 250_000_000
"""Limit of values in one log (2 GB): a small hostile file can claim, or unpack to, far more."""
MOST_COLUMNS = 10_000
"""Limit of columns in one log."""


PREFIXES = ("ctrl.", "enable.", "sensor.", "qpos.", "qvel.")
"""How our column names begin, besides `time`."""
CLOCKS = ("log", "publish", "header")
"""Clocks of the messages in a log of topics."""


@final
@dataclass(frozen=True, eq=False)
class Table:
    """The columns of one log file.

    Attributes:
        source: path of the file as the user gave it, for messages.
        columns: name to float64 values, (rows,), or (rows, k) where a cell holds a list. NaN means no sample.
        unusable: non-numeric columns, each with the error to raise if it is read. Unused text columns are allowed.
        row_numbers: (rows,) number of each row in the file; None: 1, 2, 3, ...
        label: name of the recording, with an extension; empty: the file's name.
        parts: names of single values in list columns, such as `action.elbow_flex.pos`, each with its column and index
            (None in a column of one number a row); empty where the data set has no such names.
        notes: remarks of the reader, for the user.
        units: of columns whose unit the file itself states, such as `deg`.
        stamps: columns that held time stamps or durations; they are in s, stamps from the first one on.
        restarts: rows, from 0, at which the logger began anew.
        unread: columns that are there, but were not asked for.
        labels: of columns whose own name says nothing: the name that the log gives them elsewhere, and where.
    """

    source: str
    columns: Mapping[str, np.ndarray]
    unusable: Mapping[str, InputError] = field(default_factory=dict)
    row_numbers: np.ndarray | None = None
    label: str = ""
    parts: Mapping[str, tuple[str, int | None]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    units: Mapping[str, str] = field(default_factory=dict)
    stamps: frozenset[str] = frozenset()
    restarts: tuple[int, ...] = ()
    unread: tuple[str, ...] = ()
    labels: Mapping[str, tuple[str, str]] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all columns, usable or not, read or not."""
        return (*self.columns, *self.unusable, *self.unread)

    def base(self, name: str) -> str:
        """The column that holds what `name` names: itself, or the list column that it is a part of."""
        return self.parts[name][0] if name in self.parts and name not in self.columns else name

    def rows_from(self, first: int, last: int | None = None) -> Table:
        """The same table without the rows before `first` and from `last` on."""
        row_numbers, whole = self.row_numbers, slice(first, last)
        length = max((len(values) for values in self.columns.values()), default=0)
        row_numbers = np.arange(1, length + 1) if row_numbers is None else row_numbers
        cut = {name: v[whole] if len(v) == length else v for name, v in self.columns.items()}
        return replace(self, columns=cut, row_numbers=row_numbers[whole], restarts=())

    def place(self, row: int, column: str) -> str:
        """Location of a cell, for messages: file, row (a CSV's header is row 1) and column.

        Args:
            row: 0-based index into the columns.
            column: the column's name in the file.
        """
        number = row + 1 if self.row_numbers is None else int(self.row_numbers[row])
        return f"{self.source}, row {number}, column '{column}'"

    def column(self, name: str, index: int | None = None) -> np.ndarray:
        """The values of a column, (rows,) float64.

        Args:
            name: the column's name in the file, or that of one value of a list column.
            index: which value of a list column, from 0.

        Raises:
            InputError: there is no such column, it holds no numbers, or `index` does not fit it.
        """
        if name in self.parts and name not in self.columns and index is None:
            name, index = self.parts[name]
        if name in self.unusable:
            raise self.unusable[name]
        if name not in self.columns:
            raise InputError(f"no column '{name}'", where=self.source, right=known((*self.names, *self.parts)))
        values, where = self.columns[name], f"{self.source}, column '{name}'"
        if values.ndim == 1:
            if index is not None:
                raise InputError("has one value a row, so no index", where=where, right="leave `index` out")
            return values
        index = 0 if index is None and values.shape[1] == 1 else index
        if index is None or not 0 <= index < values.shape[1]:
            what = f"has {values.shape[1]} values a row" + ("" if index is None else f", none at index {index}")
            raise InputError(what, where=where, right=f"give an index from 0 to {values.shape[1] - 1} in a manifest")
        return values[:, index]


@final
@dataclass(frozen=True)
class Selection:
    """Which part of a file that holds more than one table is read.

    Attributes:
        episode: of a LeRobot data set, from 0; None: its only one.
        clock: of an MCAP file's messages: `log` (when the logger got them), `publish` (when they were sent) or
            `header` (the stamp in the message).
        wanted: columns that will be used; None: read all. Formats without random access are read in full, and columns
            with our own names are read in any case.
        clocks: of columns that have another clock than the file's others.
    """

    episode: int | None = None
    clock: str = "log"
    wanted: frozenset[str] | None = None
    clocks: Mapping[str, str] = field(default_factory=dict)

    def asks_for(self, name: str) -> bool:
        """Whether a column is read: wanted, or one of ours, or one with parts or values that are wanted."""
        if self.wanted is None or name == "time" or name.startswith(PREFIXES):
            return True
        return name in self.wanted or any(other.startswith(f"{name}.") for other in self.wanted)


def check_size(count: int, where: str) -> None:
    """Check that a log is small enough to read, before memory is allocated for it.

    Args:
        count: how many values it claims to hold.
        where: the file.

    Raises:
        InputError: the count is negative or above `MOST_NUMBERS`.
    """
    if not 0 <= count <= MOST_NUMBERS:
        right = f"at most {MOST_NUMBERS:,}; cut the log into shorter ones, or leave columns out"
        raise InputError(f"claims to hold {count:,} numbers", where=where, right=right)


def check_width(columns: int, where: str) -> None:
    """Check that a log has at most `MOST_COLUMNS` columns.

    Raises:
        InputError: it has more.
    """
    if columns > MOST_COLUMNS:
        raise InputError(f"has {columns:,} columns", where=where, right=f"at most {MOST_COLUMNS:,}; leave some out")
