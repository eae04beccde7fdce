"""The explanation beside its rivals: a figure of the errors on training and test recordings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from estexp_jax.report.drawing.axes import draw_floor, log_axis

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

NAMES = {
    "nominal": "nominal simulator",
    "parameters_only": "parameters refitted",
    "black_box": "black-box correction",
    "placebo": "best wrong effect",
    "explained": "explained simulator",
    "noise_floor": "noise alone",
}
"""Everything with an error, in the order in which it is shown."""
_COLOURS = {"nominal": "#d95f02", "explained": "#1b6ca8"}
_RIVAL = "#7a7a7a"


def figure_competing_models(findings: Mapping[str, Any]) -> Figure:
    """Errors of all rivals: filled on test recordings, hollow on training recordings.

    Args:
        findings: as in `findings.json`.
    """
    from matplotlib.figure import Figure

    fit = findings["fit"]
    shown = [key for key in NAMES if key != "noise_floor" and fit[key]]
    figure = Figure(figsize=(5.4, 0.9 + 0.38 * len(shown)), layout="constrained")
    axes = figure.subplots()
    drawn = [error for row, key in enumerate(shown) for error in _draw(axes, row, key, fit[key])]
    axes.set_yticks(range(len(shown)), [NAMES[key] for key in shown], fontsize=9)
    for tick, key in zip(axes.get_yticklabels(), shown, strict=True):
        tick.set_fontweight("bold" if key == "explained" else "normal")
    axes.set_ylim(len(shown) - 0.4, -0.8)
    draw_floor(axes, _percent(fit["noise_floor"]["test"]), drawn)
    if drawn:
        log_axis(axes, drawn, " %")
    axes.set_xlabel("error, % of the sensors' range")
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)
    return figure


def _draw(axes: Axes, row: int, key: str, errors: Mapping[str, float | None]) -> list[float]:
    """One rival's row; the errors (per cent) that a logarithmic axis can show."""
    colour, bold = _COLOURS.get(key, _RIVAL), key == "explained"
    train, test = (_percent(errors[role]) for role in ("train", "test"))
    found = [error for error in (train, test) if error > 0.0]
    axes.axhline(row, color="0.93", lw=0.8, zorder=0)
    if len(found) == 2:
        axes.plot(found, [row, row], color=colour, lw=1.0, alpha=0.5, zorder=1)
    if train > 0.0:
        axes.plot(train, row, "o", color=colour, markerfacecolor="white", markersize=6)
    if test > 0.0:
        axes.plot(test, row, "o", color=colour, markersize=8 if bold else 6)
    if found:
        axes.annotate(
            f"{test:.3g} %" if np.isfinite(test) else "no number", (max(found), row), fontsize=8, color=colour,
            fontweight="bold" if bold else "normal", xytext=(9, 0), textcoords="offset points", va="center",
        )  # fmt: skip
    return found


def _percent(error: float | None) -> float:
    return 100.0 * error if error is not None and np.isfinite(error) else float("nan")
