"""Statistics of the runs: distances regained, diagnoses, and what was taken for what."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from scipy import stats

from experiments.harness.statistics import holm, share, signed_rank

Row = dict[str, Any]
LAST = 4
PARTIAL = (1, 2, 4, 5, 6)
"""Situations that the paper's control could not recover from."""


def arms(rows: Sequence[Row]) -> list[tuple[str, str]]:
    """Method and metric of the runs that there are."""
    return list(dict.fromkeys((row["method"], row["metric"]) for row in rows))


def of(rows: Sequence[Row], arm: tuple[str, str], situation: int) -> list[Row]:
    """Runs of one arm in one situation, by seed."""
    found = [r for r in rows if (r["method"], r["metric"]) == arm and r["situation"] == situation]
    return sorted(found, key=lambda row: row["seed"])


def distances(rows: Sequence[Row]) -> dict[str, Any]:
    """Damaged against trial 4 (signed rank, Holm over the situations of an arm), and arms against each other."""
    result: dict[str, Any] = {}
    for arm in arms(rows):
        groups = {s: of(rows, arm, s) for s in range(1, 14)}
        groups = {s: g for s, g in groups.items() if g}
        p = [signed_rank([r[f"trial_{LAST}"] for r in g], [r["damaged"] for r in g]) for g in groups.values()]
        corrected = holm(p)
        pooled = [r for s in (*range(1, 9), 10) for r in groups.get(s, [])]
        ends, starts = ([r[name] for r in pooled] for name in (f"trial_{LAST}", "damaged"))
        result[f"{' '.join(arm)}, 1 to 8 and 10 pooled"] = {"n": len(pooled), "p": signed_rank(ends, starts)}
        result[" ".join(arm)] = {
            s: {
                "n": len(g),
                **{name: float(np.mean([r[name] for r in g])) for name in ("before", "damaged", f"trial_{LAST}")},
                "gain": float(np.median([r[f"trial_{LAST}"] - r["damaged"] for r in g])),
                "p": p[i],
                "p_holm": corrected[i],
            }
            for i, (s, g) in enumerate(groups.items())
        }
    result["rolling-mean against distance"] = _between(rows, ("paper", "rolling-mean"), ("paper", "distance"))
    result["set search against the paper's"] = _between(rows, ("set", "rolling-mean"), ("paper", "rolling-mean"))
    return result


def _between(rows: Sequence[Row], a: tuple[str, str], b: tuple[str, str]) -> dict[str, Any]:
    """Median difference of trial 4, seed by seed, and the signed-rank p that the first arm comes farther."""
    result: dict[str, Any] = {}
    groups = [*((str(s), (s,)) for s in range(1, 14)), ("1, 2, 4, 5, 6", PARTIAL), ("all", tuple(range(1, 14)))]
    for name, situations in groups:
        first, second = (
            {(r["situation"], r["seed"]): r for s in situations for r in of(rows, arm, s)} for arm in (a, b)
        )
        both = sorted(set(first) & set(second))
        if both:
            x, y = ([runs[k][f"trial_{LAST}"] for k in both] for runs in (first, second))
            difference = float(np.median(np.subtract(x, y)))
            result[name] = {"n": len(both), "median_difference": difference, "p": signed_rank(x, y)}
    return result


def diagnoses(rows: Sequence[Row]) -> dict[str, Any]:
    """Share of exact sets and median error of the amounts, by arm, situation and pass."""
    result: dict[str, Any] = {}
    for arm in arms(rows):
        result[" ".join(arm)] = {
            s: [_pass(of(rows, arm, s), number) for number in range(1, LAST + 1)]
            for s in range(1, 14)
            if of(rows, arm, s)
        }
    return result


def _pass(rows: Sequence[Row], number: int) -> dict[str, Any]:
    right = [bool(r[f"right_{number}"]) for r in rows]
    errors = [r[f"error_{number}"] for r in rows if r[f"error_{number}"] is not None]
    low, high = share(sum(right), len(right))
    error = float(np.median(errors)) if errors else None
    return {"right": sum(right) / len(right), "low": low, "high": high, "n": len(right), "error_points": error}


def confusion(rows: Sequence[Row]) -> dict[str, Any]:
    """How often each kind of change was diagnosed at trial 4 where each was planted: counts of runs, by arm."""
    result: dict[str, Any] = {}
    for arm in arms(rows):
        table: dict[str, dict[str, int]] = {}
        for r in (r for r in rows if (r["method"], r["metric"]) == arm):
            line = table.setdefault("; ".join(_kinds(r["planted"])), {})
            for kind in _kinds(r[f"diagnosis_{LAST}"]):
                line[kind] = line.get(kind, 0) + 1
            line["runs"] = line.get("runs", 0) + 1
        result[" ".join(arm)] = table
    return result


def _kinds(text: str) -> list[str]:
    return sorted({part.split("@")[0].split()[0] for part in text.split("; ")})


def environment(rows: Sequence[Row]) -> dict[str, Any]:
    """Whether a slope is diagnosed where there is one, and nowhere else: Fisher's exact p for each arm."""
    result: dict[str, Any] = {}
    for arm in arms(rows):
        mine = [r for r in rows if (r["method"], r["metric"]) == arm]
        table = np.zeros((2, 2), int)
        for r in mine:
            table[int(r["situation"] != 10), int("gravity_tilt" not in r[f"diagnosis_{LAST}"])] += 1
        result[" ".join(arm)] = {"table": table.tolist(), "p": float(stats.fisher_exact(table, "greater").pvalue)}  # pyright: ignore
    return result
