"""How far the robots came."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

_BEFORE, _DAMAGED, _TRIAL = "#1b9e77", "#d95f02", "#7570b3"


def distances_figure(rows: Sequence[Mapping[str, Any]]) -> Any:
    """Before the damage, after it and in each trial; a panel for each robot and damage, a line for each seed."""
    from matplotlib.figure import Figure

    cases = list(dict.fromkeys((row["model"], row["damage"]) for row in rows))
    figure = Figure(figsize=(3.1 * len(cases), 3.0), layout="constrained")
    panels = figure.subplots(1, len(cases), sharey=True, squeeze=False)[0]
    for axes, (model, damage) in zip(panels, cases, strict=True):
        for row in rows:
            if (row["model"], row["damage"]) != (model, damage):
                continue
            trials = [value for name, value in row.items() if name.startswith("trial_")]
            steps = range(len(trials) + 2)
            axes.plot(steps, [row["before"], row["damaged"], *trials], "-", color="0.8", zorder=0)
            axes.plot(0, row["before"], "^", color=_BEFORE)
            axes.plot(1, row["damaged"], "o", color=_DAMAGED)
            axes.plot(steps[2:], trials, "s", color=_TRIAL, markersize=4)
            axes.set_xticks(list(steps), ["before", "damaged", *(f"trial {k}" for k in steps[1:-1])], rotation=60)
        axes.set_title(f"{model}\n{damage}", fontsize=8)
        axes.spines[["top", "right"]].set_visible(False)
    panels[0].set_ylabel("distance (m)")
    return figure
