"""What diagnoses come to: shares, errors, alarms, and whether probabilities mean what they say."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.harness.figures import write_figure
from experiments.harness.statistics import share

Row = dict[str, Any]
INSIDE = range(1, 11)
"""Situations that the paper's catalogue can say."""


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """Per robot, method, catalogue and number of trials."""
    groups: dict[tuple, list[Row]] = {}
    for row in rows:
        groups.setdefault((row["robot"], row["method"], row["catalogue"], row["trials"]), []).append(row)
    return {"groups": [_group(key, members) for key, members in sorted(groups.items())]}


def _group(key: tuple, rows: list[Row]) -> dict[str, Any]:
    robot, method, catalogue, trials = key
    inside = [r for r in rows if r["situation"] in INSIDE]
    outside = [r for r in rows if r["situation"] not in INSIDE]
    beyond = [r for r in rows if r["situation"] in (11, 12)]
    null = [r for r in rows if r["situation"] == 9]
    return {
        "robot": robot,
        "method": method,
        "catalogue": catalogue,
        "trials": trials,
        "seeds": len({r["seed"] for r in rows}),
        "right_1_to_10": _share(r["right"] for r in inside),
        "right_11_to_13": _share(r["right"] for r in outside),
        "nothing_added_to_9": _share(r["right"] for r in null),
        "error_points": _quantiles([r["error"] for r in inside if r["error"] is not None]),
        "alarm_1_to_10": _share(bool(r["alarm"]) for r in inside),
        "alarm_11_and_12": _share(bool(r["alarm"]) for r in beyond),
        "by_situation": {s: _situation([r for r in rows if r["situation"] == s]) for s in _situations(rows)},
        "calibration": [_bin(rows, low, low + 0.2) for low in (0.0, 0.2, 0.4, 0.6, 0.8)],
        "seconds": _quantiles([r["seconds"] for r in rows]),
    }


def _situation(rows: list[Row]) -> dict[str, Any]:
    errors = [r["error"] for r in rows if r["error"] is not None]
    return {"right": _share(r["right"] for r in rows), "error_points": _quantiles(errors)}


def _situations(rows: Iterable[Row]) -> list[int]:
    return sorted({r["situation"] for r in rows})


def _share(flags: Iterable[bool]) -> dict[str, Any] | None:
    """Share, its 90 % interval (Wilson), and of how many; None of none."""
    values = list(flags)
    if not values:
        return None
    low, high = share(sum(values), len(values))
    return {"share": sum(values) / len(values), "low": low, "high": high, "n": len(values)}


def _quantiles(values: list[float]) -> dict[str, float] | None:
    if not values:
        return None
    return {"median": float(np.median(values)), "p90": float(np.quantile(values, 0.9)), "n": len(values)}


def _bin(rows: list[Row], low: float, high: float) -> dict[str, Any]:
    top = high > 0.99
    stated = [r for r in rows if r["probability"] is not None]
    inside = [r for r in stated if low <= r["probability"] and (r["probability"] < high or top)]
    return {"from": low, "to": high, "right": _share(r["right"] for r in inside)}


def draw(found: dict[str, Any], rows: Sequence[Row], out: Path) -> None:
    """`right.png`: share of exact diagnoses by situation; `calibration.png`."""
    from matplotlib.figure import Figure

    groups = [g for g in found["groups"] if g["catalogue"] == "full"]
    figure = Figure(figsize=(9.0, 3.6), layout="constrained")
    axes = figure.add_subplot()
    width = 0.8 / max(len(groups), 1)
    for i, group in enumerate(groups):
        places = sorted(group["by_situation"])
        shares = [group["by_situation"][s]["right"]["share"] for s in places]
        name = f"{group['robot']} robot, {group['method']} search, {group['trials']} trials (n = {group['seeds']})"
        axes.bar(np.array(places) - 0.4 + (i + 0.5) * width, shares, width, label=name)
    axes.set_xticks(range(1, 14))
    axes.set_xlabel("situation")
    axes.set_ylabel("exact set named")
    axes.legend(fontsize=7, frameon=False, loc="upper center", bbox_to_anchor=(0.5, 1.3), ncols=2)
    axes.spines[["top", "right"]].set_visible(False)
    write_figure(out / "right.png", figure)
    _draw_calibration(groups, out)


def _draw_calibration(groups: list[dict[str, Any]], out: Path) -> None:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(4.2, 4.0), layout="constrained")
    axes = figure.add_subplot()
    axes.plot([0, 1], [0, 1], color="0.8", linewidth=1)
    for group in groups:
        bins = [b for b in group["calibration"] if b["right"]]
        if bins:
            middles, stated = [(b["from"] + b["to"]) / 2 for b in bins], [b["right"] for b in bins]
            shares = np.array([r["share"] for r in stated])
            error = [shares - [r["low"] for r in stated], [r["high"] for r in stated] - shares]
            label = f"{group['robot']}, {group['trials']} trials"
            axes.errorbar(middles, shares, np.maximum(error, 0.0), fmt="o-", capsize=3, label=label)
    axes.set_xlabel("probability given")
    axes.set_ylabel("share that is right, 90 % interval")
    axes.legend(fontsize=7, frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    write_figure(out / "calibration.png", figure)
