"""One page of figures of a scored set: functions of rows and board, drawn with matplotlib."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib

matplotlib.use("Agg")

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from experiments.benchmark.scoring.judge import QUIET, Row
from experiments.harness.figures import write_figure

_INK, _GOOD, _BAD, _SOFT = "#22303c", "#2a7f62", "#c0492f", "#9aa7b1"
_VERDICTS = {
    "consistent": "#9aa7b1",
    "parameters": "#5b8db8",
    "missing_physics": "#2a7f62",
    "unexplained": "#d9a441",
    "none": "#c0492f",
}


def draw_page(rows: Sequence[Row], scores: Mapping[str, Any], path: Path) -> None:
    """Draw everything into a PNG."""
    with plt.rc_context({"font.size": 8, "axes.spines.top": False, "axes.spines.right": False, "text.color": _INK}):
        figure, axes = plt.subplots(2, 3, figsize=(12.5, 7.6), layout="constrained")
        _verdicts(axes[0, 0], rows)
        _detection(axes[0, 1], scores)
        _shares(axes[0, 2], scores)
        _gains(axes[1, 0], rows)
        _calibration(axes[1, 1], rows, scores)
        _times(axes[1, 2], rows)
        write_figure(path, figure, dpi=130)
        plt.close(figure)


def draw_confusion(scores: Mapping[str, Any], path: Path) -> None:
    """True names against first claimed names."""
    table = scores["confusion"]
    truths, claims = list(table), sorted({c for row in table.values() for c in row})
    counts = np.array([[table[t].get(c, 0) for c in claims] for t in truths])
    with plt.rc_context({"font.size": 8}):
        figure, ax = plt.subplots(figsize=(3.2 + 0.42 * len(claims), 1.6 + 0.24 * len(truths)), layout="constrained")
        ax.imshow(
            np.where(counts > 0, counts, np.nan), cmap="GnBu", vmin=0, vmax=2 * max(2, counts.max()), aspect="auto"
        )
        for i, j in np.argwhere(counts > 0):
            ax.text(j, i, str(counts[i, j]), ha="center", va="center", fontsize=7)
        ax.set_xticks(range(len(claims)), claims, rotation=60, ha="right")
        ax.set_yticks(range(len(truths)), truths)
        ax.set_xlabel("first name claimed, or (verdict)")
        ax.set_ylabel("what was concealed")
        write_figure(path, figure, dpi=130)
        plt.close(figure)


def _verdicts(ax: Axes, rows: Sequence[Row]) -> None:
    groups = sorted({r.group for r in rows}, key=lambda g: (g not in QUIET, g))
    left = np.zeros(len(groups))
    for verdict, colour in _VERDICTS.items():
        n = np.array([sum(r.group == g and r.verdict == verdict for r in rows) for g in groups])
        if n.any():
            ax.barh(groups, n, left=left, color=colour, label=verdict.replace("_", " "))
        left = left + n
    ax.invert_yaxis()
    ax.xaxis.set_major_locator(MaxNLocator(integer=True))
    ax.set_title("Verdicts by what was concealed", loc="left", pad=20)
    ax.set_xlabel("cases")
    ax.legend(
        frameon=False, fontsize=7, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=5, handlelength=1, columnspacing=1
    )


def _detection(ax: Axes, scores: Mapping[str, Any]) -> None:
    bins = scores["by_visibility"]
    labels = [
        f"< {b['to']:g}"
        if not b["from"]
        else f"> {b['from']:g}"
        if b["to"] is None
        else f"{b['from']:g} to {b['to']:g}"
        for b in bins
    ]
    for shift, (key, colour, label) in zip(
        (-0.15, 0.0, 0.15),
        (
            ("detected", _INK, "noticed"),
            ("place_first", "#5b8db8", "place first"),
            ("name_first", _GOOD, "named (odd laws: declined)"),
        ),
        strict=True,
    ):
        asked = [(i, b[key]) for i, b in enumerate(bins) if b[key]["n"]]
        x = np.array([i for i, _ in asked]) + shift
        y = np.array([s["share"] for _, s in asked])
        error = np.abs([[s["share"] - s["low"] for _, s in asked], [s["high"] - s["share"] for _, s in asked]])
        ax.errorbar(x, y, error, fmt="o", color=colour, label=label, ms=4, lw=1, capsize=2)
    counts = [b["detected"]["n"] for b in bins]
    ax.set_xticks(range(len(bins)), [f"{a}\nn = {n}" for a, n in zip(labels, counts, strict=True)])
    ax.set_ylim(-0.03, 1.03)
    ax.set_xlabel("visibility on unseen recordings, noise floors")
    ax.set_title("Found, against how visible it is (95 % intervals)", loc="left", pad=20)
    ax.legend(frameon=False, fontsize=7, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3, handlelength=1)


def _shares(ax: Axes, scores: Mapping[str, Any]) -> None:
    asked = (
        ("false alarms", scores["false_alarms"]["all"], 0.03, False),
        ("noticed", scores["detected"], None, True),
        ("place first", scores["place_first"], 0.92, True),
        ("place in first three", scores["place_three"], None, True),
        ("name first", scores["name_first"], 0.85, True),
        ("... or says the same", scores["name_with_equivalents"], None, True),
        ("wrong name for odd laws", scores["wrong_name_outside_catalogue"], 0.10, False),
        ("abstains where it should", scores["abstains_where_it_should"], None, True),
        ("intervals cover (of 90 %)", scores["sizes"]["covered"], 0.90, True),
    )
    for i, (_, s, goal, up) in enumerate(asked):
        if s["n"]:
            missed = goal is not None and (s["share"] < goal if up else s["share"] > goal)
            colour = _BAD if missed else _GOOD if goal is not None else _INK
            ax.plot([s["low"], s["high"]], [i, i], color=colour, lw=1.5)
            ax.plot(s["share"], i, "o", color=colour, ms=5)
        if goal is not None:
            ax.plot(goal, i, "|", color=_SOFT, ms=14, mew=2)
    ax.set_yticks(range(len(asked)), [f"{n} ({s['k']}/{s['n']})" for n, s, *_ in asked])
    ax.invert_yaxis()
    ax.set_xlim(-0.02, 1.02)
    ax.set_title("Shares (grey bar: the goal)", loc="left", pad=20)


def _gains(ax: Axes, rows: Sequence[Row]) -> None:
    ordered = sorted((r for r in rows if r.errors and r.floor), key=lambda r: r.errors["nominal"] / (r.floor or 1.0))
    for name, colour, marker in (
        ("nominal", _SOFT, "o"),
        ("parameters_only", "#5b8db8", "s"),
        ("explained", _GOOD, "D"),
    ):
        y = [r.errors.get(name, np.nan) / (r.floor or 1.0) for r in ordered]
        ax.plot(range(len(ordered)), y, marker, color=colour, ms=4, label=name.replace("_", " "))
    ax.axhline(1.0, color=_BAD, lw=0.8)
    ax.set_yscale("log")
    ax.set_xlabel("case, sorted by the nominal simulator's error")
    ax.set_ylabel("error on test recordings, noise floors")
    ax.set_title("Unseen recordings (red: noise)", loc="left")
    ax.legend(frameon=False, fontsize=7)


def _calibration(ax: Axes, rows: Sequence[Row], scores: Mapping[str, Any]) -> None:
    claims = [(r.probability, bool(r.name_equivalent)) for r in rows if r.probability is not None and r.claimed]
    ax.plot([0, 1], [0, 1], color=_SOFT, lw=1)
    if claims:
        p, y = np.array(claims, dtype=float).T
        order = np.argsort(p, kind="stable")
        parts = [b for b in np.array_split(order, 5) if len(b)]
        ax.plot([p[b].mean() for b in parts], [y[b].mean() for b in parts], "o", color=_GOOD)
    ece = scores["calibration"]["ece"]
    ax.set_xlim(0, 1.02)
    ax.set_ylim(-0.02, 1.02)
    ax.set_xlabel("probability stated")
    ax.set_ylabel("share right")
    ax.set_title(f"Calibration of {len(claims)} claims" + (f", error {ece:.2f}" if ece is not None else ""), loc="left")


def _times(ax: Axes, rows: Sequence[Row]) -> None:
    robots = sorted({r.robot for r in rows})
    times = [[r.wall_s for r in rows if r.robot == name and r.wall_s is not None] for name in robots]
    for i, found in enumerate(times):
        ax.plot(
            np.full(len(found), i) + np.linspace(-0.15, 0.15, max(len(found), 1))[: len(found)],
            found,
            "o",
            color=_INK,
            ms=4,
        )
    ax.set_xticks(range(len(robots)), robots, rotation=20)
    ax.set_ylim(0, None)
    ax.set_ylabel("s a case")
    ax.set_title("Time", loc="left")
