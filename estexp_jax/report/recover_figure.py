"""Figures of a recovery run: its progress in the shape of the paper's Figure 6, and the ways the robot went."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import numpy as np

from estexp_jax.physics.changes import Change
from estexp_jax.recovery.state import RunState

_BEFORE, _DAMAGED, _TRIAL, _SIMULATED = "#1b9e77", "#d95f02", "#7570b3", "#555555"


def progress_figure(state: RunState, axis: str) -> Any:
    """Distance over the generations of all explorations.

    Dotted: the best in the simulator as diagnosed then. Triangle: the robot before the damage; circle: after it;
    squares: the hardware trials. Captions: the diagnoses, where the passes meet.

    Args:
        state: the run; may still be under way.
        axis: of the distance.

    Returns:
        A matplotlib figure, drawn without a display.

    Source: Bongard and Lipson 2004, Figure 6.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(10.0, 5.0), layout="constrained")
    axes = figure.add_subplot()
    ends = _draw_explorations(axes, state)
    _draw_trials(axes, state, axis, ends)
    top = axes.get_ylim()[1]
    for end, diagnosis in zip(ends, state.diagnoses, strict=False):
        axes.axvline(end, color="0.85", zorder=0)
        axes.text(end, top, f" {_caption(diagnosis)}", va="bottom", ha="left", fontsize=7)
    axes.set_xlabel("generations of exploration")
    axes.set_ylabel(f"distance along {axis} (m)")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), fontsize=8, frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def path_figure(state: RunState, axis: str) -> Any:
    """The root's way seen from above: before the damage, after it, and in the last trial; all to one scale.

    Args:
        state: the run, with its damage done.
        axis: of the distance, for the titles.
    """
    from matplotlib.figure import Figure

    first, *later = state.trials
    walks = [("before", state.before, _BEFORE), ("damaged", first, _DAMAGED)]
    walks += [(f"trial {len(later)}", later[-1], _TRIAL)] if later else []
    figure = Figure(figsize=(3.2 * len(walks), 3.2), layout="constrained")
    panels = figure.subplots(1, len(walks), sharex=True, sharey=True, squeeze=False)[0]
    for axes, (title, trial, colour) in zip(panels, walks, strict=True):
        if trial is not None:
            way = trial.position[:, :2] - trial.position[0, :2]
            axes.plot(way[:, 0], way[:, 1], color=colour)
            axes.plot(*way[0], "o", color="0.3", markersize=4)
            axes.plot(*way[-1], "s", color=colour, markersize=5)
            title += f": {trial.distance(axis):.2f} m"
        axes.set_title(title, fontsize=9)
        axes.set_aspect("equal", adjustable="box")
        axes.set_xlabel("x (m)")
    panels[0].set_ylabel("y (m)")
    return figure


def _draw_explorations(axes: Any, state: RunState) -> list[int]:
    """Dotted curves one after another; where each ends, generations."""
    start, ends = 0, []
    rows = [row for row in state.history if row.phase == "exploration"]
    for number in sorted({row.number for row in rows}):
        best = np.array([row.best for row in rows if row.number == number])
        label = "best in the simulator" if not ends else None
        x = start + np.arange(1, len(best) + 1)
        axes.plot(x, np.where(np.isfinite(best), best, np.nan), ":", color=_SIMULATED, label=label)
        start += len(best)
        ends.append(start)
    return ends


def _draw_trials(axes: Any, state: RunState, axis: str, ends: Sequence[int]) -> None:
    if state.before is not None and state.trials:
        axes.plot(ends[0], state.before.distance(axis), "^", color=_BEFORE, label="before the damage")
        axes.plot(ends[0], state.trials[0].distance(axis), "o", color=_DAMAGED, label="damaged")
    distances = [trial.distance(axis) for trial in state.trials[1:]]
    if distances:
        axes.plot(ends[1 : len(distances) + 1], distances, "s", color=_TRIAL, label="hardware trial")


def _caption(diagnosis: Sequence[Change]) -> str:
    text = "\n ".join(fill(change.sentence(), 28, subsequent_indent=" ") for change in diagnosis)
    return text or "nothing differs"
