"""What a diagnosis is worth: distances of the last trial against those of runs whose diagnosis was the true damage."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.harness.figures import write_figure

Row = dict[str, Any]
Pair = tuple[Row, Row]
"""A run that diagnosed, and the one that knew the damage."""
LAST = "trial_4"
_HALF = 0.5
"""Damage that leaves less of the distance than this is severe."""


def summary(pairs: Sequence[Pair]) -> dict[str, Any]:
    """By robot and situation: medians over seeds, and how often a severely damaged robot came twice as far again."""
    return {
        robot: {
            "situations": {str(s): _situation(own) for s, own in by_situation(mine).items()},
            "ratio": _median_ratio(mine),
            "severe": _severe(mine),
        }
        for robot, mine in by_robot(pairs).items()
    }


def by_robot(pairs: Sequence[Pair]) -> dict[str, list[Pair]]:
    """Pairs of either robot, where there are some."""
    robots = dict.fromkeys(own["robot"] for own, _ in pairs)
    return {robot: [p for p in pairs if p[0]["robot"] == robot] for robot in robots}


def by_situation(pairs: Sequence[Pair]) -> dict[int, list[Pair]]:
    """Pairs of each situation."""
    return {s: [p for p in pairs if p[0]["situation"] == s] for s in sorted({own["situation"] for own, _ in pairs})}


def _median_ratio(pairs: Sequence[Pair]) -> float | None:
    """Share of the oracle run's last distance that the diagnosing one reached, of pairs in which that got anywhere."""
    shares = [own[LAST] / oracle[LAST] for own, oracle in pairs if oracle[LAST] > 0.0]
    return float(np.median(shares)) if shares else None


def _situation(pairs: Sequence[Pair]) -> dict[str, Any]:
    medians = {name: float(np.median([own[name] for own, _ in pairs])) for name in ("before", "damaged", LAST)}
    oracle = float(np.median([run[LAST] for _, run in pairs]))
    right = float(np.mean([own["right_4"] for own, _ in pairs]))
    return {"n": len(pairs), **medians, "oracle": oracle, "ratio": _median_ratio(pairs), "right": right}


def _severe(pairs: Sequence[Pair]) -> dict[str, int]:
    own = [run for run, _ in pairs if run["damaged"] < _HALF * run["before"]]
    return {"n": len(own), "twice": sum(run[LAST] >= 2.0 * run["damaged"] for run in own)}


def draw(pairs: Sequence[Pair], out: Path) -> None:
    """`distances.png`: each run's last distance against that of the one that knew the damage."""
    from matplotlib.figure import Figure

    groups = by_robot(pairs)
    if not groups:
        return
    figure = Figure(figsize=(4.2 * len(groups), 4.0), layout="constrained")
    panels = figure.subplots(1, len(groups), squeeze=False)[0]
    for axes, (robot, mine) in zip(panels, groups.items(), strict=True):
        x, y = ([pair[i][LAST] for pair in mine] for i in (1, 0))
        ends = min(*x, *y, 0.0), 1.05 * max(*x, *y)
        axes.plot(ends, ends, color="0.6", linewidth=0.8)
        right = np.array([bool(own["right_4"]) for own, _ in mine])
        for holds, marker, label in ((right, "o", "exact diagnosis"), (~right, "x", "another")):
            axes.plot(np.asarray(x)[holds], np.asarray(y)[holds], marker, color="0.2", markersize=4, label=label)
        axes.set_title(f"{robot} robot (n = {len(mine)})", fontsize=9)
        axes.set_xlabel("with the true damage: trial 4 (m)")
        axes.set_ylabel("diagnosing it: trial 4 (m)")
        axes.set_aspect("equal")
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(fontsize=7, frameon=False)
    write_figure(out / "distances.png", figure)
