"""What is asked of a set beside what was measured: lines of a table, and the page around it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from estexp_jax.runs import write_text
from experiments.benchmark.scoring.board import share
from experiments.benchmark.scoring.judge import Row

Line = tuple[str, str, str]
"""What, how much is wanted, what was found."""
T = TypeVar("T")


def share_text(rows: Iterable[T], right: Callable[[T], object]) -> str:
    """How many of some rows are right, with the 95 % interval; a dash where nothing was asked."""
    found = share(rows, right)
    if not found["n"]:
        return "-"
    return f"{found['k']} of {found['n']} ({100 * found['low']:.0f} to {100 * found['high']:.0f} %)"


def gain_text(rows: Sequence[Row]) -> str:
    """Median of the held-out gain with its quartiles; a program that failed gains nothing."""
    gains = [r.gain if r.gain is not None else 0.0 for r in rows]
    if not gains:
        return "-"
    low, high = np.quantile(gains, [0.25, 0.75])
    return f"{100 * float(np.median(gains)):.0f} %, quartiles {100 * low:.0f} and {100 * high:.0f} %"


def size_error_text(rows: Sequence[Row]) -> str:
    """Relative errors of parameters of rightly named effects: median and 90th percentile."""
    errors = [s.error for r in rows for s in r.sizes]
    if not errors:
        return "-"
    middle, high = np.quantile(errors, [0.5, 0.9])
    return f"{100 * middle:.1f} %, {100 * high:.0f} % ({len(errors)} parameters)"


def coverage_text(rows: Sequence[Row]) -> str:
    """How many intervals of parameters hold the true value."""
    sizes = [s for r in rows for s in r.sizes]
    return f"{sum(s.covered for s in sizes)} of {len(sizes)}" if sizes else "-"


def better_text(rows: Sequence[Row], model: str) -> str:
    """How often the explanation predicts held-out recordings better than another model."""
    asked = [r for r in rows if model in r.errors and "explained" in r.errors]
    return share_text(asked, lambda r: r.errors["explained"] < r.errors[model])


def onset_text(rows: Sequence[Row]) -> str:
    """Error of the onset."""
    errors = [r.onset_error for r in rows if r.onset_error is not None]
    return f"{100 * float(np.median(errors)):.1f} % of the recording ({len(errors)})" if errors else "-"


def time_text(rows: Sequence[Row]) -> str:
    """Wall time of a case."""
    walls = [r.wall_s for r in rows if r.wall_s is not None]
    return f"{float(np.median(walls)):.0f} s, longest {max(walls):.0f} s" if walls else "-"


def write_tables(
    page: Path, explained: int, whole: int, tables: Mapping[str, Sequence[Line]], rest: Sequence[str]
) -> Path:
    """Write a page of scores as Markdown; gives its path.

    Args:
        page: its path.
        explained: cases that have been explained.
        whole: cases of the set.
        tables: by what they are of.
        rest: lines after the tables.
    """
    lines = [f"{explained} of {whole} cases explained."]
    for name, table in tables.items():
        lines += ["", f"| {name}".rstrip() + " | wanted | found |", "|---|---|---|"]
        lines += [f"| {what} | {wanted} | {found} |" for what, wanted, found in table]
    write_text(page, "\n".join([*lines, "", *rest]))
    return page
