"""The columns of a log file, before they are bound to a robot."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import final

import numpy as np

from estexp_jax.errors import InputError, known

MOST_NUMBERS = 250_000_000
"""Limit of values in one log (2 GB): a small hostile file can claim, or unpack to, far more."""
MOST_COLUMNS = 10_000
"""Limit of columns in one log."""


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
        parts: names of single values in list columns, such as `action.elbow_flex.pos`, each with its column and index;
            empty where the data set has no such names.
        notes: remarks of the reader, for the user.
    """

    source: str
    columns: Mapping[str, np.ndarray]
    unusable: Mapping[str, InputError] = field(default_factory=dict)
    row_numbers: np.ndarray | None = None
    label: str = ""
    parts: Mapping[str, tuple[str, int]] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all columns, usable or not."""
        return (*self.columns, *self.unusable)

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
        wanted: columns that will be used; None: read all. Formats without random access are read in full.
    """

    episode: int | None = None
    clock: str = "log"
    wanted: frozenset[str] | None = None


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
