"""The cells of one column of a text log, as numbers or time stamps."""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import final

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.csv_form import ABSENT, SWITCHES
from estexp_jax.recordings.readers.stamps import is_stamp, parsed_stamps

_COMMA = re.compile(r"[+-]?\d*,\d+([eE][+-]?\d+)?")


@final
@dataclass(eq=False)
class TextColumn:
    """The values of one column, in pieces, or the first fault in it."""

    name: str
    pieces: list[np.ndarray] = field(default_factory=list)
    error: InputError | None = None
    marks: set[str] = field(default_factory=set)

    def add(self, cells: Sequence[str], lines: Sequence[int], path: Path, decimal_comma: bool) -> None:
        """Add the cells of some rows."""
        if self.error is not None:
            return
        values, wrong = _parse_numbers(cells, self.marks if decimal_comma else None)
        if wrong is not None:
            stamps = parsed_stamps(["" if cell.strip().lower() in ABSENT else cell.strip() for cell in cells])
            if stamps is None or not all(p.dtype == stamps.dtype or _is_empty(p) for p in self.pieces):
                self.error = self._fault(cells[wrong], lines[wrong], path)
                return
            values = stamps
        self.pieces.append(values)

    def _fault(self, cell: str, line: int, path: Path) -> InputError:
        what, right = f"'{cell[:80]}' is not a number", "a number, or an empty cell for no sample"
        right += "; times also as 2026-02-03T10:20:30.5, 10:20:30.5 or 0.5 sec" if re.search(r"\d\D+\d", cell) else ""
        if self.marks >= {",", "."}:
            what, right = f"'{cell[:80]}' is after a decimal point or comma of the other kind", "one kind in a column"
        return InputError(what, where=f"{path}, row {line}, column '{self.name}'", right=right)

    def values(self) -> np.ndarray:
        """All values, of time stamps too."""
        kind = next((piece.dtype for piece in self.pieces if is_stamp(piece) and not _is_empty(piece)), None)
        if kind is not None:
            return np.concatenate([np.full(len(p), "NaT", kind) if _is_empty(p) else p for p in self.pieces])
        return np.concatenate([np.empty(0), *self.pieces])


def _is_empty(piece: np.ndarray) -> bool:
    return bool((np.isnat(piece) if is_stamp(piece) else np.isnan(piece)).all())


def _parse_numbers(cells: Sequence[str], marks: set[str] | None) -> tuple[np.ndarray, int | None]:
    """The cells as numbers, and the index of the first that is none.

    Args:
        cells: of one column.
        marks: which decimal marks the column has had, where the comma may be one; it is added to.
    """
    if marks is None:
        try:
            return np.array(list(map(float, cells)), dtype=np.float64), None
        except ValueError:
            pass
    values: list[float] = []
    for index, cell in enumerate(cells):
        text = cell.strip()
        if marks is not None:
            marks |= {mark for mark in ".," if mark in text}
            text = text.replace(",", ".") if _COMMA.fullmatch(text) and "." not in marks else text
        small = text.lower()
        if small in ABSENT or small in SWITCHES:
            values.append(SWITCHES.get(small, math.nan))
            continue
        try:
            values.append(float(text))
        except ValueError:
            return np.array(values), index
        if marks is not None and marks >= {",", "."}:
            return np.array(values), index
    return np.array(values, dtype=np.float64), None
