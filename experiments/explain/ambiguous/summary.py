"""How often one more recording settles an ambiguity: a proposed one, or a random one of the same length."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.harness.figures import write_figure
from experiments.harness.statistics import share

Row = Mapping[str, Any]
WAYS = ("random", "proposed")


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """By ambiguity, and of all: cases, how many were open before, and of those how many each way settles.

    A case is open where the right effect and another one of the ambiguity are listed. It is settled where the right one
    is named, alone.
    """
    names = dict.fromkeys(row["ambiguity"] for row in rows)
    return {**{name: _settled([r for r in rows if r["ambiguity"] == name]) for name in names}, "all": _settled(rows)}


def is_open(row: Row) -> bool:
    """Whether the first recordings leave the right effect and another one of the ambiguity."""
    listed = str(row["before_listed"] or "").split()
    return row["truth"] in listed and len(listed) > 1


def _settled(rows: Sequence[Row]) -> dict[str, Any]:
    left = [row for row in rows if is_open(row)]
    return {"n": len(rows), "open": len(left), **{way: _share([bool(r[f"{way}_alone"]) for r in left]) for way in WAYS}}


def _share(settled: Sequence[bool]) -> dict[str, Any]:
    low, high = share(sum(settled), len(settled))
    return {"settled": sum(settled), "share": float(np.mean(settled)) if settled else None, "low": low, "high": high}


def draw(rows: Sequence[Row], out: Path) -> None:
    """`settled.png`: shares of open cases that are settled, with 90 % intervals."""
    from matplotlib.figure import Figure

    found = {name: own for name, own in summary(rows).items() if own["open"]}
    if not found:
        return
    figure = Figure(figsize=(7.0, 0.8 + 0.5 * len(found)), layout="constrained")
    axes, y = figure.subplots(), -np.arange(len(found))
    for i, (way, colour) in enumerate(zip(WAYS, ("0.6", "tab:blue"), strict=True)):
        shares = np.array([own[way]["share"] for own in found.values()])
        ends = np.array([[own[way]["low"], own[way]["high"]] for own in found.values()])
        error = np.maximum(np.abs(ends.T - shares), 0.0)
        axes.barh(y + 0.18 - 0.36 * i, shares, 0.34, xerr=error, color=colour, capsize=2, label=f"one {way} recording")
    axes.axvline(0.8, color="black", linewidth=0.8, linestyle=":")
    axes.set_yticks(y, [f"{name} (n = {own['open']})" for name, own in found.items()])
    axes.set_xlim(0.0, 1.0)
    axes.set_xlabel("right one named alone afterwards: share, 90 % interval")
    figure.legend(fontsize=8, frameon=False, loc="outside upper right", ncols=2)
    axes.spines[["top", "right"]].set_visible(False)
    write_figure(out / "settled.png", figure)
