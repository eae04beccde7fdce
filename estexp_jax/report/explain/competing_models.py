"""Figure of the errors of all competing models on training and test recordings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from estexp_jax.report.drawing.axes import EXPLAINED, NOMINAL, OTHER, WIDTH, draw_noise_floor, label_rows, log_axis
from estexp_jax.report.drawing.onto import new_figure

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
"""Models with an error, in the order in which they are shown."""
_COLOURS = {"nominal": NOMINAL, "explained": EXPLAINED}


def figure_competing_models(findings: Mapping[str, Any]) -> Figure:
    """Errors of all models: filled on test recordings, hollow on training recordings.

    Args:
        findings: as in `findings.json`.
    """
    fit = findings["fit"]
    keys = [key for key in NAMES if key != "noise_floor" and fit[key]]
    figure = new_figure(WIDTH, 0.9 + 0.38 * len(keys))
    axes = figure.subplots()
    drawn = [error for row, key in enumerate(keys) for error in _draw_model(axes, row, key, fit[key])]
    bold = [row for row, key in enumerate(keys) if key == "explained"]
    label_rows(axes, range(len(keys)), [NAMES[key] for key in keys], bold=bold)
    axes.set_ylim(len(keys) - 0.4, -0.8)
    draw_noise_floor(axes, _percent(fit["noise_floor"]["test"]), drawn)
    if drawn:
        log_axis(axes, drawn, " %")
    axes.set_xlabel("error, % of the sensors' range")
    return figure


def _draw_model(axes: Axes, row: int, key: str, errors: Mapping[str, float | None]) -> list[float]:
    """Draw one model's row; returns its positive errors, per cent, which a logarithmic axis can show."""
    colour, bold = _COLOURS.get(key, OTHER), key == "explained"
    train, test = (_percent(errors[role]) for role in ("train", "test"))
    positive = [error for error in (train, test) if error > 0.0]
    axes.axhline(row, color="0.93", lw=0.8, zorder=0)
    if len(positive) == 2:
        axes.plot(positive, [row, row], color=colour, lw=1.0, alpha=0.5, zorder=1)
    if train > 0.0:
        axes.plot(train, row, "o", color=colour, markerfacecolor="white", markersize=6)
    if test > 0.0:
        axes.plot(test, row, "o", color=colour, markersize=8 if bold else 6)
    if positive:
        axes.annotate(
            f"{test:.3g} %" if np.isfinite(test) else "no number", (max(positive), row), fontsize=8, color=colour,
            fontweight="bold" if bold else "normal", xytext=(9, 0), textcoords="offset points", va="center",
        )  # fmt: skip
    return positive


def _percent(error: float | None) -> float:
    return 100.0 * error if error is not None and np.isfinite(error) else float("nan")
