"""The figure, and the numbers beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from experiments.harness.figures import write_figure
from experiments.harness.statistics import signed_rank

_NAMES = ("motor weaker by 10 %", "the same by 20 %", "a touch sensor by 50 %")


def draw(found: dict[str, Any], times: dict[str, np.ndarray], table: list[dict[str, Any]], out: Path) -> dict[str, Any]:
    """`divergence.png`; gives the summary."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(11.0, 3.4), layout="constrained")
    one, many, ranks = figure.subplots(1, 3)
    _trace(one, found["inputs"], times)
    top = found["inputs"].shape[2]
    for name, t in times.items():
        many.step(np.sort(t), np.arange(1, len(t) + 1) / len(t), where="post", label=f"{name} damage")
    many.set(xscale="log", xlabel="control steps until readings part", ylabel="share of controllers", xlim=(1, top))
    many.legend(fontsize=7, frameon=False)
    for w in dict.fromkeys(row["w"] for row in table if row["w"]):
        rows = [row for row in table if row["w"] == w]
        ranks.errorbar(
            [r["h"] for r in rows],
            [r["correlation"] for r in rows],
            [r["standard_error"] for r in rows],
            label=f"w = {w}",
        )
    ranks.axhline(table[-1]["correlation"], color="0.5", linestyle=":", label="distance")
    ranks.set(xscale="log", xlabel="h, control steps", ylabel="rank correlation with the true error", ylim=(-0.1, 1.0))
    ranks.legend(fontsize=7, frameon=False)
    for axes in (one, many, ranks):
        axes.spines[["top", "right"]].set_visible(False)
    write_figure(out / "divergence.png", figure)
    return {
        "median_steps": {name: float(np.median(t)) for name, t in times.items()},
        "similar_later_in": int(np.sum(times["similar"] > times["unlike"])),
        "equal_in": int(np.sum(times["similar"] == times["unlike"])),
        "p_similar_later": signed_rank(times["similar"].tolist(), times["unlike"].tolist()),
        "correlations": table,
    }


def _trace(axes: Any, inputs: np.ndarray, times: dict[str, np.ndarray]) -> None:
    """The controller whose two times are nearest to the medians, its first angle sensor."""
    far = sum(np.abs(np.log1p(t) - np.log1p(np.median(t))) for t in times.values())
    angle = inputs.shape[-1] // 2
    for robot, name in enumerate(_NAMES):
        axes.plot(inputs[int(np.argmin(far)), robot, :500, angle], linewidth=1, label=name)
    axes.set(xlabel="control step", ylabel="angle sensor", ylim=(-1.05, 1.6))
    axes.legend(fontsize=7, frameon=False, loc="upper right")
