"""How many trials a diagnosis needs, by the way in which the next trial is chosen."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.harness.figures import write_figure
from experiments.harness.statistics import share, signed_rank

Row = dict[str, Any]
WAYS = {"diagnosis": ("drawn", "informative"), "loop": ("farthest", "informative")}
"""Ways to choose the next trial in either part: as before, and the one that is put to the test."""


def summary(rows: Sequence[Row]) -> dict[str, Any]:
    """Of each part that has rows: share that is right after each trial, trials needed, and whether fewer are."""
    return {part: _part([r for r in rows if r["part"] == part], WAYS[part]) for part in WAYS if _has(rows, part)}


def _has(rows: Sequence[Row], part: str) -> bool:
    return any(r["part"] == part for r in rows)


def _part(rows: Sequence[Row], ways: tuple[str, str]) -> dict[str, Any]:
    needed = {way: trials_needed([r for r in rows if r["next_trial"] == way]) for way in ways}
    both = sorted(set(needed[ways[0]]) & set(needed[ways[1]]))
    pairs = [(needed[ways[0]][key], needed[ways[1]][key]) for key in both]
    by_way = {way: _way([r for r in rows if r["next_trial"] == way], needed[way]) for way in ways}
    fewer = {"pairs": len(pairs), "fewer": sum(a > b for a, b in pairs), "more": sum(a < b for a, b in pairs)}
    p = signed_rank([a for a, _ in pairs], [b for _, b in pairs]) if pairs else None
    return {**by_way, "paired": {**fewer, "p": p}}


def trials_needed(rows: Sequence[Row]) -> dict[tuple[int, int], int]:
    """Of each situation and seed: trials until a diagnosis is right and stays so; one more than all if none does."""
    found: dict[tuple[int, int], dict[int, bool]] = {}
    for r in rows:
        found.setdefault((r["situation"], r["seed"]), {})[r["trials"]] = bool(r["right"])
    return {key: max((n for n, right in each.items() if not right), default=0) + 1 for key, each in found.items()}


def _way(rows: Sequence[Row], needed: dict[tuple[int, int], int]) -> dict[str, Any]:
    return {
        "n": len(needed),
        "right_after": {str(n): _share([r for r in rows if r["trials"] == n]) for n in _numbers(rows)},
        "trials_needed": {"mean": float(np.mean(list(needed.values()))), "median": float(np.median([*needed.values()]))}
        if needed
        else None,
    }


def _numbers(rows: Sequence[Row]) -> list[int]:
    return sorted({r["trials"] for r in rows})


def _share(rows: Sequence[Row]) -> dict[str, Any]:
    right = sum(bool(r["right"]) for r in rows)
    low, high = share(right, len(rows))
    return {"share": right / len(rows), "low": low, "high": high, "n": len(rows)}


def draw(rows: Sequence[Row], out: Path) -> None:
    """`next_trial.png`: share of exact diagnoses after each trial, with 90 % intervals."""
    from matplotlib.figure import Figure

    found = summary(rows)
    if not found:
        return
    figure = Figure(figsize=(4.4 * len(found), 3.6), layout="constrained")
    for axes, (part, own) in zip(figure.subplots(1, len(found), squeeze=False)[0], found.items(), strict=True):
        for i, (way, colour) in enumerate(zip(WAYS[part], ("0.55", "tab:blue"), strict=True)):
            after = own[way]["right_after"]
            x, shares = np.array([int(n) for n in after]), np.array([s["share"] for s in after.values()])
            ends = np.array([[s["low"], s["high"]] for s in after.values()]).reshape(-1, 2)
            error = np.maximum(np.abs(ends.T - shares), 0.0)
            label = f"{_WORDS[way]} (n = {own[way]['n']})"
            axes.errorbar(x + 0.06 * i, shares, error, fmt="o-", color=colour, capsize=3, markersize=4, label=label)
        axes.set_xticks([1, 2, 3, 4])
        axes.set_ylim(0.0, 1.02)
        axes.set_xlabel("trials")
        axes.set_ylabel("exact set named, 90 % interval")
        axes.set_title({"diagnosis": "walkers of the library", "loop": "the whole loop"}[part], fontsize=9)
        axes.legend(fontsize=7, frameon=False, loc="lower right")
        axes.spines[["top", "right"]].set_visible(False)
    write_figure(out / "next_trial.png", figure)


_WORDS = {"drawn": "drawn at random", "farthest": "the farthest", "informative": "the most informative"}
