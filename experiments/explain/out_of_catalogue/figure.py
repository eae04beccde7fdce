"""Truth against found: the force of one case of each law."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from experiments.harness.figures import write_figure

_COLUMNS = 4
_TRUE, _FOUND = "#222222", "#1b6ca8"


def draw_laws(entries: Sequence[Mapping[str, Any]], path: Path) -> None:
    """One panel a law, of the case with the median error, over what the force depends on more: position or speed."""
    from matplotlib.figure import Figure

    laws: dict[str, list[Mapping[str, Any]]] = {}
    for e in entries:
        laws.setdefault(e["truth"], []).append(e)
    if not laws:
        return
    rows = -(-len(laws) // _COLUMNS)
    figure = Figure(figsize=(2.6 * _COLUMNS, 2.1 * rows), layout="constrained")
    panels = figure.subplots(rows, _COLUMNS, squeeze=False).ravel()
    for axes in panels[len(laws) :]:
        axes.remove()
    for axes, (law, each) in zip(panels, sorted(laws.items()), strict=False):
        entry = sorted(each, key=lambda e: e["force"]["error"])[len(each) // 2]
        force = entry["force"]
        true, found = np.array(force["true"]), np.array(force["found"])
        name = max(("q", "w"), key=lambda name: explained(np.array(force[name]), true))
        x = np.array(force[name])
        axes.plot(x, true, ".", ms=2.5, color=_TRUE, label="true")
        axes.plot(x, found, ".", ms=1.5, color=_FOUND, label="found")
        if np.ptp(axes.get_ylim()) < 0.2 * np.abs(true).max():  # a constant, of which only its rounding would show
            axes.set_ylim(*sorted((0.0, 1.2 * float(true[0]))))
        axes.set_title(f"{law.replace('_', ' ')}, {entry['robot']}, {100 * force['error']:.0f} % off", fontsize=8)
        axes.set_xlabel("q (rad)" if name == "q" else "w (rad/s)", fontsize=8)
        axes.tick_params(labelsize=7)
        axes.locator_params(axis="x", nbins=6)
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].set_ylabel("force (N m)", fontsize=8)
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper left", ncols=2, frameon=False, fontsize=8, markerscale=3)
    write_figure(path, figure, dpi=130)


def explained(x: np.ndarray, y: np.ndarray, bins: int = 20) -> float:
    """Share of the variance of y that its mean in bins of equal count of x explains."""
    parts = np.array_split(y[np.argsort(x, kind="stable")], bins)
    within = sum(float(np.sum((part - part.mean()) ** 2)) for part in parts)
    return 1.0 - within / max(float(np.sum((y - y.mean()) ** 2)), 1e-30)
