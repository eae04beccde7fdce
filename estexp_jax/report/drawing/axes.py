"""Colours and parts of axes that figures of several reports share."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes

WIDTH = 5.4
"""Width of a figure, inches: narrow, so that its text stays readable on a phone."""
RECORDED, NOMINAL, EXPLAINED, OTHER = "#222222", "#d95f02", "#1b6ca8", "#7a7a7a"
"""Colours of recordings, of the nominal and of the explained simulator, and of all other models."""


def draw_noise_floor(axes: Axes, floor: float, errors: Sequence[float]) -> None:
    """A line at the error of noise alone, labelled on the side where most errors are."""
    if floor > 0.0:
        offset, side = (3, "left") if not len(errors) or floor < np.median(errors) else (-3, "right")
        axes.axvline(floor, color="0.5", ls=":", lw=1.2)
        axes.annotate(
            "noise", (floor, 1.0), xycoords=("data", "axes fraction"), xytext=(offset, -2), textcoords="offset points",
            fontsize=8, color="0.4", va="top", ha=side,
        )  # fmt: skip


def log_axis(axes: Axes, errors: list[float], unit: str = "") -> None:
    """A logarithmic x axis with a unit at its labels, and room for numbers at the right."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set_xscale("log")
    low, high = axes.get_xlim()
    high = max(high, max(errors))
    axes.set_xlim(low, high * (high / low) ** 0.16)
    axes.xaxis.set_major_locator(LogLocator(numticks=6))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}{unit}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def label_rows(
    axes: Axes, heights: Sequence[float], labels: Sequence[str], *, bold: Collection[int] = (), fontsize: int = 9
) -> None:
    """Label rows on the y axis, without ticks and frame.

    Args:
        axes: of the rows.
        heights: y of each row.
        labels: of each row; they may contain dollars.
        bold: indices of the rows that stand out.
        fontsize: of the labels, points.
    """
    axes.set_yticks(heights, labels, fontsize=fontsize, parse_math=False)
    for row in bold:
        axes.get_yticklabels()[row].set_fontweight("bold")
    axes.spines[["top", "right", "left"]].set_visible(False)
    axes.tick_params(axis="y", length=0)


def short(text: str, max_letters: int = 30) -> str:
    """A name with each long line cut in its middle, since beginnings and ends of names differ most."""
    half = (max_letters - 1) // 2
    lines = text.split("\n")
    return "\n".join(line if len(line) <= max_letters else f"{line[:half]}…{line[-half:]}" for line in lines)
