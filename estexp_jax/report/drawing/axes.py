"""What figures of several reports draw alike."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from matplotlib.axes import Axes


def draw_floor(axes: Axes, floor: float, errors: Sequence[float]) -> None:
    """A line at the error that noise alone gives, its name on the side where most errors are."""
    if floor > 0.0:
        aside, side = (3, "left") if not len(errors) or floor < np.median(errors) else (-3, "right")
        axes.axvline(floor, color="0.5", ls=":", lw=1.2)
        axes.annotate(
            "noise", (floor, 1.0), xycoords=("data", "axes fraction"), xytext=(aside, -2), textcoords="offset points",
            fontsize=8, color="0.4", va="top", ha=side,
        )  # fmt: skip


def log_axis(axes: Axes, errors: list[float], unit: str = "") -> None:
    """Logarithmic, with room for numbers at the right, its labels followed by a unit."""
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    axes.set_xscale("log")
    low, high = axes.get_xlim()
    high = max(high, max(errors))
    axes.set_xlim(low, high * (high / low) ** 0.16)
    axes.xaxis.set_major_locator(LogLocator(numticks=6))
    axes.xaxis.set_major_formatter(FuncFormatter(lambda x, _: f"{x:g}{unit}"))
    axes.xaxis.set_minor_formatter(NullFormatter())


def short(text: str, most: int = 30) -> str:
    """A name, each line cut in its middle if it is long: beginnings and ends of names tell the most."""
    half = (most - 1) // 2
    lines = text.split("\n")
    return "\n".join(line if len(line) <= most else f"{line[:half]}…{line[-half:]}" for line in lines)
