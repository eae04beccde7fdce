"""Distance recovered by trials on the damaged robot, with a diagnosis and without."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.harness.figures import write_figure
from experiments.harness.statistics import interval, signed_rank

Row = dict[str, Any]
WAYS = {
    "diagnosis": "the full algorithm",
    "repertoire": "repertoire of gaits, as many simulated walks",
    "tenfold": "repertoire of gaits, ten times as many",
}


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """By robot: median share of the distance before the damage, of the best trial so far; and with equal trials."""
    return {
        robot: _of_robot([r for r in rows if r["robot"] == robot]) for robot in dict.fromkeys(r["robot"] for r in rows)
    }


def recovered(rows: Sequence[Row], way: str) -> np.ndarray:
    """Best distance so far (rows, trials), as a share of that before the damage; trials that all rows have."""
    names = [f"{way}_{i}" for i in range(sum(name.startswith(f"{way}_") for name in rows[0]))]
    table = np.array([[r.get(name, np.nan) for name in names] for r in rows], float)
    table = table[:, np.all(np.isfinite(table), axis=0)]
    return np.maximum.accumulate(table, axis=1) / np.array([[r["before"]] for r in rows])


def _of_robot(rows: Sequence[Row]) -> dict[str, Any]:
    shares = {way: recovered(rows, way) for way in WAYS}
    result: dict[str, Any] = {"n": len(rows)}
    result["median_share"] = {way: np.median(table, axis=0).round(4).tolist() for way, table in shares.items()}
    full = shares.pop("diagnosis")
    for way, table in shares.items():
        last = min(table.shape[1], full.shape[1]) - 1
        a, b = full[:, last].tolist(), table[:, last].tolist()
        result[way] = {
            "gaits": float(np.median([r[f"gaits_{way}"] for r in rows])),
            "best_undamaged": float(np.median([r[f"best_{way}"] / r["before"] for r in rows])),
            "with_equal_trials": {
                "trials": last + 1,
                "better": sum(x > y for x, y in zip(a, b, strict=True)),
                "p": signed_rank(a, b),
            },
            "trials_to_equal": _to_equal(float(np.median(a)), np.median(table, axis=0)),
        }
    return result


def _to_equal(share: float, medians: np.ndarray) -> int | None:
    """Trials without diagnosis after which their median reaches a share; None if never."""
    reached = np.flatnonzero(medians >= share)
    return int(reached[0]) + 1 if len(reached) else None


def draw(rows: Sequence[Row], out: Path) -> None:
    """`repertoire.png`: best distance so far by trials, mean with its 90 % interval."""
    from matplotlib.figure import Figure

    robots = list(dict.fromkeys(r["robot"] for r in rows))
    if not robots:
        return
    figure = Figure(figsize=(4.4 * len(robots), 3.6), layout="constrained")
    for axes, robot in zip(figure.subplots(1, len(robots), squeeze=False)[0], robots, strict=True):
        own = [r for r in rows if r["robot"] == robot]
        for (way, words), colour in zip(WAYS.items(), ("tab:blue", "0.55", "tab:orange"), strict=True):
            table = recovered(own, way)
            x, ends = np.arange(1, table.shape[1] + 1), np.array([interval(column.tolist()) for column in table.T])
            axes.plot(x, table.mean(axis=0), "o-", color=colour, markersize=3, label=words)
            axes.fill_between(x, ends[:, 0], ends[:, 1], color=colour, alpha=0.2, linewidth=0)
        axes.axhline(1.0, color="0.8", linewidth=0.8)
        axes.set_title(f"{robot} robot (n = {len(own)})", fontsize=9)
        axes.set_xlabel("trials on the damaged robot")
        axes.set_ylabel("best distance so far / before the damage")
        axes.set_ylim(bottom=0.0)
        axes.legend(fontsize=7, frameon=False)
        axes.spines[["top", "right"]].set_visible(False)
    write_figure(out / "repertoire.png", figure)
