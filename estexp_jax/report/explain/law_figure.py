"""Figure of an unknown law: its force, and the force that is missing without it, at the recorded states."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from estexp_jax.discovery.law_findings import COVERED
from estexp_jax.report.drawing.axes import EXPLAINED, WIDTH
from estexp_jax.report.drawing.onto import new_figure

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from estexp_jax.discovery.law_forces import LawForces

_LACKING = "#a0a0a0"
_BINS = 60


def figure_law(law: LawForces, unit: str = "rad") -> Figure:
    """Force over position and over speed, above the density of samples; dotted lines bound the covered range.

    Args:
        law: forces at the recorded states of the joint.
        unit: of the joint's position, rad or m.
    """
    figure = new_figure(WIDTH, 4.2)
    panels = figure.subplots(2, 2, sharex="col", sharey="row", gridspec_kw={"height_ratios": [4, 1]})
    fast = np.quantile(np.abs(law.w), COVERED[1])
    sides = (
        (law.q, np.quantile(law.q, COVERED), f"q ({unit})"),
        (law.w, (-fast, fast), f"w ({unit}/s)"),
    )
    for (above, below), (x, edges, label) in zip(panels.T, sides, strict=True):
        above.plot(x, law.lacking, ".", color=_LACKING, ms=2.0, alpha=0.5, label="lacking", rasterized=True)
        above.plot(x, law.given, ".", color=EXPLAINED, ms=2.0, label="law", rasterized=True)
        above.spines[["top", "right"]].set_visible(False)
        _draw_density(below, x)
        for edge in edges:
            above.axvline(edge, color="0.5", ls=":", lw=1.0)
        below.set_xlabel(label)
    panels[0, 0].set_ylabel("force (N m)" if unit == "rad" else "force (N)")
    figure.suptitle(law.joint, fontsize=10, x=0.02, ha="left", parse_math=False)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper right", ncols=2, frameon=False, fontsize=9, markerscale=4)
    return figure


def _draw_density(axes: Axes, x: np.ndarray) -> None:
    axes.hist(x, bins=_BINS, color="0.8")
    axes.set_yticks([])
    axes.spines[["top", "right", "left"]].set_visible(False)
