"""Drop the rows of a log at which its clock stands still or runs backwards."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estexp_jax.recordings.columns import LARGEST, Source
from estexp_jax.recordings.table import Table


def strictly_increasing(table: Table, clock: Source) -> tuple[Table, str]:
    """Keep only the rows whose time is later than all times before.

    Args:
        table: the log.
        clock: source of its time.

    Returns:
        The log, and a sentence that describes the faults of its clock; the sentence is empty if there were none.
    """
    if clock.column is None:
        return table, ""
    time = clock.read(table, 0)
    if not (np.abs(time) <= LARGEST).all() or len(time) < 2:
        return table, ""
    latest = np.concatenate([[-np.inf], np.maximum.accumulate(time)[:-1]])
    keep = time > latest
    if keep.all():
        return table, ""
    steps = np.diff(time, prepend=-np.inf)
    problems = []
    for rows, verb in ((np.flatnonzero(steps == 0.0), "stands still"), (np.flatnonzero(steps < 0.0), "runs backwards")):
        if len(rows):
            problems.append(f"{verb} at {len(rows)} rows (first: {table.place(int(rows[0]), clock.column)})")
    row_numbers = np.arange(1, len(time) + 1) if table.row_numbers is None else table.row_numbers
    columns = {name: values[keep] for name, values in table.columns.items() if len(values) == len(keep)}
    columns |= {name: values for name, values in table.columns.items() if name not in columns}
    what = f"time: {' and '.join(problems)}; {int((~keep).sum())} rows are left out here, but explain refuses such a"
    what += " log: log each reading once with its own time, or take these rows out"
    return replace(table, columns=columns, row_numbers=row_numbers[keep]), what
