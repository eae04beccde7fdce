"""The figure, and the numbers beside it."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy import stats

from experiments.harness.figures import write_figure
from experiments.recover.figure8.count import Count

_KINDS = (("rolling-mean", "evolved"), ("rolling-mean", "random"), ("distance", "evolved"), ("distance", "random"))


def draw(counts: Sequence[Count], out: Path) -> dict[str, Any]:
    """`dominants.png`: how many dominants first estimations have; gives the summary."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8.0, 3.4), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    summary: dict[str, Any] = {}
    most = max(count.generations for count in counts)
    for metric, axes in zip(("rolling-mean", "distance"), panels, strict=True):
        for kind in (k for k in _KINDS if k[0] == metric):
            first = _first(counts, *kind)
            axes.hist(first, bins=np.arange(-0.5, most + 1.5), histtype="step", label=kind[1])
            summary[" ".join(kind)] = {"median": float(np.median(first)), "most": int(max(first)), "n": len(first)}
        axes.set(title=metric, xlabel="generations with a dominant")
        axes.legend(fontsize=7, frameon=False)
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].set_ylabel("first estimations")
    write_figure(out / "dominants.png", figure)
    a, b = (_first(counts, metric, "evolved") for metric in ("rolling-mean", "distance"))
    p = stats.mannwhitneyu(a, b, alternative="greater").pvalue  # pyright: ignore
    better = {metric: _beaten(counts, metric) for metric in ("rolling-mean", "distance")}
    return {"generations_with_dominants": summary, "p_rolling_mean_has_more": float(p), "evolved_beats_random": better}


def _first(counts: Sequence[Count], metric: str, search: str) -> list[int]:
    return [c.generations for c in counts if (c.metric, c.search, c.estimation) == (metric, search, 1)]


def _beaten(counts: Sequence[Count], metric: str) -> float:
    """In what share of runs the first estimation ends with a lower residual than random search."""
    ends = {
        search: {
            (c.situation, c.seed): c.residual
            for c in counts
            if (c.metric, c.search, c.estimation) == (metric, search, 1)
        }
        for search in ("evolved", "random")
    }
    return float(np.mean([ends["evolved"][k] < ends["random"][k] for k in ends["random"]]))
