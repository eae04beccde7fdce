"""Figures: distances as in the paper's Figure 7, and what was taken for what."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.harness.figures import write_figure
from experiments.harness.statistics import interval
from experiments.recover.figure7.summary import LAST, arms, of

_BARS = (("before", "before", "white"), ("damaged", "damaged", "0.8"), (f"trial_{LAST}", f"trial {LAST}", "0.4"))


def draw_distances(rows: Sequence[dict[str, Any]], out: Path) -> None:
    """`distances.png`: means and their 90 % bootstrap intervals."""
    from matplotlib.figure import Figure

    found = arms(rows)
    figure = Figure(figsize=(9.0, 2.4 * len(found)), layout="constrained")
    panels = figure.subplots(len(found), 1, sharex=True, sharey=True, squeeze=False)[:, 0]
    for axes, arm in zip(panels, found, strict=True):
        for i, (column, label, colour) in enumerate(_BARS):
            for situation in range(1, 14):
                values = [r[column] for r in of(rows, arm, situation)]
                if values:
                    mean, ends = float(np.mean(values)), interval(values)
                    error = np.maximum([[mean - ends[0]], [ends[1] - mean]], 0.0)
                    place = situation + 0.28 * (i - 1)
                    name = label if situation == 1 else None
                    axes.bar(place, mean, 0.26, color=colour, edgecolor="0.3", linewidth=0.6, label=name)
                    axes.errorbar(place, mean, error, color="0.2", linewidth=0.8, capsize=1.5)
        n = min(len(of(rows, arm, s)) for s in range(1, 14))
        axes.set_title(f"{arm[0]} search, {arm[1]} metric (n = {n})", fontsize=9)
        axes.set_ylabel("distance (m)")
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].legend(fontsize=7, frameon=False, ncols=3, loc="upper right")
    panels[-1].set_xticks(range(1, 14))
    panels[-1].set_xlabel("situation")
    write_figure(out / "distances.png", figure)


def draw_confusion(tables: dict[str, Any], out: Path) -> None:
    """`confusion.png`: of the runs where a set of kinds was planted, the share in which each kind was diagnosed."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.4 * len(tables), 5.0), layout="constrained")
    panels = figure.subplots(1, len(tables), squeeze=False)[0]
    planted = sorted({name for table in tables.values() for name in table})
    diagnosed = sorted({k for table in tables.values() for line in table.values() for k in line if k != "runs"})
    for axes, (name, table) in zip(panels, tables.items(), strict=True):
        shares = np.array([[_share(table.get(row, {}), kind) for kind in diagnosed] for row in planted])
        axes.imshow(shares, vmin=0.0, vmax=1.0, cmap="Greys", aspect="auto")
        axes.set_xticks(range(len(diagnosed)), [_short(k) for k in diagnosed], rotation=90, fontsize=7)
        axes.set_yticks(range(len(planted)), [_short(p) for p in planted] if axes is panels[0] else [], fontsize=7)
        axes.set_title(name, fontsize=9)
        axes.set_xlabel("diagnosed at trial 4")
    panels[0].set_ylabel("planted")
    write_figure(out / "confusion.png", figure)


def _share(line: dict[str, int], kind: str) -> float:
    return line.get(kind, 0) / line["runs"] if line else np.nan


def _short(name: str) -> str:
    return name.replace("; ", " + ").replace("_", " ")
