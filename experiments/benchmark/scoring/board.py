"""The scoreboard: all cases together, every share with its interval."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import numpy as np

from experiments.benchmark.scoring.judge import QUIET, Row

BINS = (0.0, 1.0, 3.0, 10.0, 30.0, np.inf)
"""Edges of visibility, noise floors."""
OUTSIDE_CATALOGUE = ("unknown", "relative")
"""Groups whose laws no catalogue holds."""


def wilson(k: int, n: int, z: float = 1.96) -> tuple[float, float]:
    """Wilson's score interval of a share k / n (Wilson, JASA 22, 1927); (0, 1) for n = 0.

    (p + z^2/2n -+ z sqrt(p (1 - p) / n + z^2 / 4n^2)) / (1 + z^2 / n)
    """
    if n == 0:
        return 0.0, 1.0
    p, a = k / n, z * z / n
    middle, half = (p + a / 2.0) / (1.0 + a), z * np.sqrt(p * (1.0 - p) / n + a / (4.0 * n)) / (1.0 + a)
    return float(max(0.0, middle - half)), float(min(1.0, middle + half))


_T = TypeVar("_T")


def share(rows: Iterable[_T], right: Callable[[_T], Any]) -> dict[str, Any]:
    """How many of some rows are right, as `{k, n, share, low, high}`; without those that are not asked."""
    asked = [bool(x) for x in map(right, rows) if x is not None]
    k, n = sum(asked), len(asked)
    low, high = wilson(k, n)
    return {"k": k, "n": n, "share": k / n if n else None, "low": low, "high": high}


def ece(probabilities: Sequence[float], right: Sequence[bool], bins: int = 5) -> float | None:
    """Expected calibration error over bins of equal count: sum n_b / n |mean p - share right|; None for no claim."""
    if not probabilities:
        return None
    order = np.argsort(probabilities, kind="stable")
    p, y = np.asarray(probabilities)[order], np.asarray(right, dtype=float)[order]
    parts = [b for b in np.array_split(np.arange(len(p)), bins) if len(b)]
    return float(sum(len(b) / len(p) * abs(p[b].mean() - y[b].mean()) for b in parts))


def board(rows: Sequence[Row], oracle: Mapping[str, float] | None = None) -> dict[str, Any]:
    """All scores.

    Args:
        rows: judged cases.
        oracle: held-out gain of the true model, by those cases where it is known.
    """
    quiet = [r for r in rows if r.group in QUIET]
    shown = [r for r in rows if r.visible and r.group not in ("hidden", *OUTSIDE_CATALOGUE)]
    outside = [r for r in rows if r.visible and r.group in OUTSIDE_CATALOGUE]
    hidden = [r for r in rows if r.group == "hidden"]
    claims = [(r.probability, bool(r.name_equivalent)) for r in rows if r.probability is not None and r.claimed]
    return {
        "cases": len(rows),
        "failed": share(rows, lambda r: r.verdict == "none"),
        "false_alarms": {
            "all": share(quiet, lambda r: r.alarm),
            **{g: share([r for r in quiet if r.group == g], lambda r: r.alarm) for g in QUIET},
        },
        "converged": share(rows, lambda r: r.converged),
        "detected": share(shown + outside, lambda r: r.detected),
        "by_visibility": by_visibility(rows),
        "by_group": by_group(rows),
        "place_first": share(shown + outside, lambda r: r.place_first),
        "place_three": share(shown + outside, lambda r: r.place_three),
        "name_first": share(shown, lambda r: r.name_first),
        "name_with_equivalents": share(shown, lambda r: r.name_equivalent),
        "both_named": share([r for r in shown if "+" in r.truth], lambda r: r.named_all),
        "wrong_name_outside_catalogue": share(outside, lambda r: r.wrong_name),
        "confusion": confusion(rows),
        "sizes": sizes(rows),
        "onset": onset(rows),
        "abstains_where_it_should": share(hidden + outside, abstained),
        "abstains_where_it_should_not": share(shown, lambda r: r.verdict in ("consistent", "unexplained", "none")),
        "calibration": {"claims": len(claims), "ece": ece([p for p, _ in claims], [y for _, y in claims])},
        "gain": gains(shown, oracle or {}),
        "cost": cost(rows),
    }


def abstained(row: Row) -> bool:
    """No name was given where none can be known."""
    quiet = ("consistent", "parameters") if row.group == "hidden" else ("unexplained",)
    return row.verdict in quiet or (row.group in OUTSIDE_CATALOGUE and row.wrong_name is False and bool(row.name_first))


def by_visibility(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Detection, place and name in bins of visibility."""
    planted, found = [r for r in rows if r.group not in QUIET and r.group != "hidden"], []
    for low, high in zip(BINS[:-1], BINS[1:], strict=True):
        inside = [r for r in planted if low <= r.shown < high]
        parts = {
            "detected": lambda r: r.detected,
            "place_first": lambda r: r.place_first,
            "name_first": lambda r: r.name_equivalent,
        }
        found.append(
            {"from": low, "to": None if np.isinf(high) else high} | {k: share(inside, f) for k, f in parts.items()}
        )
    return found


def by_group(rows: Sequence[Row]) -> dict[str, dict[str, Any]]:
    """Verdicts, place, name of each group, all visibilities."""
    found = {}
    for group in sorted({r.group for r in rows}):
        own = [r for r in rows if r.group == group]
        found[group] = {
            "cases": len(own),
            "visible": sum(r.visible for r in own),
            "verdicts": dict(Counter(r.verdict for r in own)),
            "place_first": share(own, lambda r: r.place_first),
            "name": share(own, lambda r: r.name_equivalent),
        }
    return found


def confusion(rows: Sequence[Row]) -> dict[str, dict[str, int]]:
    """True name to first claimed name (or the verdict, where none was claimed), counted."""
    table: dict[str, Counter[str]] = {}
    for r in rows:
        first = r.claimed[0].split("@")[0] if r.claimed and r.verdict == "missing_physics" else f"({r.verdict})"
        table.setdefault(r.truth, Counter())[first] += 1
    return {truth: dict(counted) for truth, counted in sorted(table.items())}


def sizes(rows: Sequence[Row]) -> dict[str, Any]:
    """Relative errors of parameters of rightly named effects, and how often their intervals cover the truth."""
    every = [s for r in rows for s in r.sizes]
    errors = [s.error for s in every]
    quantiles = np.quantile(errors, [0.5, 0.9]).tolist() if errors else [None, None]
    return {"median": quantiles[0], "p90": quantiles[1], "covered": _counted([s.covered for s in every])}


def _counted(right: Sequence[bool]) -> dict[str, Any]:
    low, high = wilson(sum(right), len(right))
    return {
        "k": sum(right),
        "n": len(right),
        "share": sum(right) / len(right) if right else None,
        "low": low,
        "high": high,
    }


def onset(rows: Sequence[Row]) -> dict[str, Any]:
    """Error of the onset as a share of the recording."""
    errors = [r.onset_error for r in rows if r.onset_error is not None]
    return {"cases": len(errors), "median": float(np.median(errors)) if errors else None}


def gains(rows: Sequence[Row], oracle: Mapping[str, float]) -> dict[str, Any]:
    """Held-out gain, its share of the oracle's where known, and how often the explanation beats each baseline."""
    own = {r.case: r.gain for r in rows if r.gain is not None}
    shares = [gain / oracle[case] for case, gain in own.items() if case in oracle]
    baselines = sorted({n for r in rows for n in r.errors} - {"explained"})
    return {
        "cases": len(own),
        "median": float(np.median(list(own.values()))) if own else None,
        "quartiles": np.quantile(list(own.values()), [0.25, 0.75]).tolist() if own else None,
        "with_oracle": len(shares),
        "median_share_of_oracle": float(np.median(shares)) if shares else None,
        "better_than": {
            n: share(
                [r for r in rows if n in r.errors and "explained" in r.errors],
                lambda r, n=n: r.errors["explained"] < r.errors[n],
            )
            for n in baselines
        },
    }


def cost(rows: Sequence[Row]) -> dict[str, Any]:
    """Time and simulated steps of a case."""
    walls = [r.wall_s for r in rows if r.wall_s is not None]
    steps = [r.robot_steps for r in rows if r.robot_steps is not None]
    return {
        "wall_s": {"median": float(np.median(walls)), "largest": float(max(walls))} if walls else None,
        "robot_steps_median": float(np.median(steps)) if steps else None,
    }
