"""Logs whose clock stands still or runs backwards, without the rows that do."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estexp_jax.recordings.columns import LARGEST, Source
from estexp_jax.recordings.table import Table


def strictly_increasing(table: Table, clock: Source) -> tuple[Table, str]:
    """Leave out the rows whose time is not later than all times before.

    Args:
        table: the log.
        clock: the source of its time.

    Returns:
        The log, and what was wrong with its clock, a sentence for the user; empty where nothing was.
    """
    if clock.column is None:
        return table, ""
    time = clock.read(table, 0)
    if not (np.abs(time) <= LARGEST).all() or len(time) < 2:
        return table, ""
    before = np.concatenate([[-np.inf], np.maximum.accumulate(time)[:-1]])
    keep = time > before
    if keep.all():
        return table, ""
    steps = np.diff(time, prepend=-np.inf)
    told = []
    for rows, verb in ((np.flatnonzero(steps == 0.0), "stands still"), (np.flatnonzero(steps < 0.0), "runs backwards")):
        if len(rows):
            told.append(f"{verb} at {len(rows)} rows (first: {table.place(int(rows[0]), clock.column)})")
    numbers = np.arange(1, len(time) + 1) if table.row_numbers is None else table.row_numbers
    columns = {name: values[keep] for name, values in table.columns.items() if len(values) == len(keep)}
    columns |= {name: values for name, values in table.columns.items() if name not in columns}
    what = f"time: {' and '.join(told)}; {int((~keep).sum())} rows are left out here, but explain refuses such a log: "
    what += "log each reading once with its own time, or take these rows out"
    return replace(table, columns=columns, row_numbers=numbers[keep]), what
