"""Rows of a log that its clocks rule out: before the first command, of an earlier start, or of two clocks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import final

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.recordings.columns import LARGEST, Source
from estexp_jax.recordings.table import Table

_LATE_S = 3600.0
"""A single command may have been sent this long before the readings, s; two clocks are further apart."""


_SHORTEST = 1e-12
"""Time steps below this, s, count as zero: no clock resolves less."""


def row_times(table: Table, source: Source) -> np.ndarray:
    """The time of each row (rows,), s, strictly increasing.

    Raises:
        InputError: it is a constant, empty or infinite, stands still or runs backwards, or has under two rows.
    """
    if source.value is not None:
        raise InputError("time cannot be a constant", where=table.source, right="map a column of the log")
    column = source.column or "time"
    values = source.read(table, 0)
    if len(values) < 2:
        raise InputError(f"has {len(values)} rows", where=table.source, right="at least two")
    usable = np.abs(values) <= LARGEST
    if not usable.all():
        where = table.place(int(np.argmin(usable)), column)
        raise InputError("the time is empty or not finite", where=where, right="every row needs its time")
    steps = np.diff(values)
    steps[(steps > 0.0) & (steps < _SHORTEST)] = 0.0
    if (steps <= 0.0).any():
        row = int(np.argmax(steps <= 0.0)) + 1
        verb = "stands still" if steps[row - 1] == 0.0 else "runs backwards"
        what = f"time {verb}: {float(values[row])!r} s after {float(values[row - 1])!r} s"
        raise InputError(what, where=table.place(row, column), right="strictly increasing times")
    return values


@final
@dataclass(frozen=True)
class SampledSpan:
    """When a column has samples.

    Attributes:
        column: its name in the log.
        first: time of its first sample, s.
        last: time of its last one, s.
        count: how many it has.
    """

    column: str
    first: float
    last: float
    count: int


def sampled_span(column: str, time: np.ndarray, values: np.ndarray) -> SampledSpan | None:
    """When a column (rows,) has samples; None if it has none."""
    rows = np.flatnonzero(np.isfinite(values))
    return SampledSpan(column, float(time[rows[0]]), float(time[rows[-1]]), len(rows)) if len(rows) else None


def check_overlap(spans: Mapping[str, SampledSpan], where: str) -> None:
    """Check that columns were stamped by one clock: the times of two are not far apart.

    Args:
        spans: our column name to when it has samples.
        where: the log.

    Raises:
        InputError: two columns are further apart than either is long.
    """
    for one, two in combinations(spans.values(), 2):
        early, later = (one, two) if one.first <= two.first else (two, one)
        gap, longest = later.first - early.last, max(early.last - early.first, later.last - later.first, 1.0)
        if gap > (longest if early.count > 1 and later.count > 1 else max(longest, _LATE_S)):
            what = f"the clocks of {early.column} ({early.first:.4g} to {early.last:.4g} s) and {later.column}"
            what += f" ({later.first:.6g} to {later.last:.6g} s) do not overlap"
            right = 'stamp both by one clock: in a log of topics choose clock = "log", for the file or for a column'
            raise InputError(what, where=where, right=right)


def longest_run(table: Table, clock: Source) -> tuple[Table, str]:
    """Of a log that was begun anew in one file, with its clock, the longest part.

    Returns:
        The part, and a sentence about what is left out; the log itself and an empty one if the clock went on.
    """
    if not table.restarts or clock.column is None:
        return table, ""
    time = clock.read(table, 0)
    breaks = [row for row in table.restarts if 0 < row < len(time) and not time[row] > time[row - 1]]
    if not breaks:
        return table, ""
    firsts, ends = [0, *breaks], [*breaks, len(time)]
    first, last = max(zip(firsts, ends, strict=True), key=_length)
    note = f"the log begins anew {len(breaks)} times, and so does its clock; its longest part is read"
    return table.rows_from(first, last), f"{note}, from {table.place(first, clock.column)}, {last - first} rows"


def _length(part: tuple[int, int]) -> int:
    return part[1] - part[0]


def first_command(ctrl: Mapping[str, np.ndarray], time: np.ndarray, where: str) -> tuple[int, str]:
    """The first row in which every actuator has had a command.

    Args:
        ctrl: our column name to its values (rows,), NaN where there is no command.
        time: (rows,) s.
        where: the log.

    Returns:
        The row, and a sentence about the rows before it; it is empty if there are none.

    Raises:
        InputError: an actuator has no command at all, or fewer than two rows are left.
    """
    first, name = 0, ""
    for ours, values in ctrl.items():
        rows = np.flatnonzero(~np.isnan(values))
        if not len(rows):
            right = "a command in at least one row; a constant is { value = 0.0 } in a manifest"
            raise InputError(f"every command of {ours} is empty", where=where, right=right)
        if rows[0] > first:
            first, name = int(rows[0]), ours
    if not first:
        return 0, ""
    if len(time) - first < 2:
        right = "at least two; record on after the command"
        raise InputError(f"has {len(time) - first} rows from the first command of {name} on", where=where, right=right)
    lost = float(time[first] - time[0])
    return first, f"{first} rows ({lost:.3g} s) before the first command of {name.partition('.')[2]} are left out"
