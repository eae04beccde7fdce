"""The figure, and the numbers beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.harness.figures import write_figure
from experiments.recover.figure1.direct import RECOVERED


def draw(
    runs: Sequence[dict[str, Any]], walked: dict[str, list[list[float]]], rows: Sequence[dict[str, Any]], out: Path
) -> dict[str, Any]:
    """`trial_cost.png`: best share of the distance recovered over hardware trials; gives the summary."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(6.0, 3.6), layout="constrained")
    axes = figure.add_subplot()
    for i, run in enumerate(runs):
        best = np.array(run["best"]) / run["before"]
        axes.plot(np.arange(1, len(best) + 1), best, color="0.6", linewidth=0.8, label=None if i else "on the robot")
    for name, label, colour in (("set_search", "set search", "#7570b3"), ("paper", "the paper's", "#1b9e77")):
        for i, (course, run) in enumerate(zip(walked[name], runs, strict=True)):
            best = np.maximum.accumulate(course) / run["before"]
            legend = None if i else f"full algorithm, {label}"
            axes.plot(np.arange(1, len(best) + 1), best, "o-", color=colour, markersize=3, linewidth=0.8, label=legend)
    axes.axhline(RECOVERED, color="0.8", linewidth=1, zorder=0)
    axes.set(
        xscale="log",
        xlabel="hardware trials on the damaged robot",
        ylabel="distance / distance before",
        ylim=(-0.2, None),
    )
    axes.legend(fontsize=7, frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    write_figure(out / "trial_cost.png", figure)
    return {name: _needed([row[name] for row in rows]) for name in ("on_the_robot", "set_search", "paper")}


def _needed(needed: list[int | None]) -> dict[str, Any]:
    """Median counts runs that never recovered as infinitely long."""
    values = np.array([np.inf if n is None else n for n in needed], float)
    return {"median": float(np.median(values)), "recovered": int(np.sum(np.isfinite(values))), "n": len(values)}
