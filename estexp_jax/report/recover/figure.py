"""Figures of a recovery run: its progress, as in the paper's Figure 6, and the paths of the robot."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.state import RunState
from estexp_jax.report.drawing.axes import WIDTH
from estexp_jax.report.drawing.onto import new_figure

_LETTERS = 88
"""Total width of the captions above the axes, letters."""
_BEFORE, _DAMAGED, _TRIAL, _SIMULATED = "#1b9e77", "#d95f02", "#7570b3", "#555555"


def progress_figure(state: RunState, axis: str, *, stands_in: bool = False) -> Any:
    """Distance over the generations of all explorations.

    Dotted: the best controller in the simulator with the diagnosis of that pass. Triangle: the robot before the damage;
    circle: after it; squares: the hardware trials. Captions: the diagnoses, at the end of each pass.

    Args:
        state: the run; it may still be under way.
        axis: of the distance.
        stands_in: the values before the damage are the simulator's.

    Returns:
        A matplotlib figure, drawn without a display.

    Source: Bongard and Lipson 2004, Figure 6.
    """
    figure = new_figure(WIDTH, 4.4)
    axes = figure.add_subplot()
    ends = _draw_explorations(axes, state)
    _draw_trials(axes, state, axis, ends, _before(stands_in))
    captions = _captions(state.diagnoses, _LETTERS // max(len(ends), 1))
    for end, caption in zip(ends, captions, strict=False):
        axes.axvline(end, color="0.85", zorder=0)
        axes.annotate(
            caption, (end, 1.0), xycoords=("data", "axes fraction"), xytext=(2, 3), textcoords="offset points",
            va="bottom", ha="left", fontsize=7, parse_math=False,
        )  # fmt: skip
    axes.set_xlim(0, max(ends, default=1))
    axes.set_xlabel("generations of exploration")
    axes.set_ylabel(f"distance along {axis} (m)")
    # Below the axes, since curves are inside and captions above.
    figure.legend(loc="outside lower center", ncols=2, fontsize=9, frameon=False)
    axes.spines[["top", "right"]].set_visible(False)
    return figure


def path_figure(state: RunState, axis: str, *, stands_in: bool = False) -> Any:
    """The root's path from above: before the damage, after it, and in the last trial; each begins at the dot.

    Args:
        state: the run, after the damage.
        axis: of the distance, for the legend.
        stands_in: the values before the damage are the simulator's.
    """
    first, *later = state.trials
    paths = [(_before(stands_in), state.before, _BEFORE), ("damaged", first, _DAMAGED)]
    paths += [(f"trial {len(later)}", later[-1], _TRIAL)] if later else []
    figure = new_figure(WIDTH, 3.4)
    axes = figure.add_subplot()
    for title, trial, colour in paths:
        if trial is not None:
            path = trial.position[:, :2] - trial.position[0, :2]
            distance = trial.distance(axis)
            label = f"{title}: {distance:.2f} m" if np.isfinite(distance) else title
            axes.plot(path[:, 0], path[:, 1], color=colour, label=label)
            axes.plot(*path[-1], "s", color=colour, markersize=6)
    axes.plot(0.0, 0.0, "o", color="0.3", markersize=5)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_xlabel("x (m)")
    axes.set_ylabel("y (m)")
    axes.spines[["top", "right"]].set_visible(False)
    close = {"handlelength": 1.0, "handletextpad": 0.4, "columnspacing": 1.0}
    figure.legend(loc="outside upper center", ncols=len(paths), fontsize=9, frameon=False, **close)
    return figure


def _draw_explorations(axes: Any, state: RunState) -> list[int]:
    """Draw dotted curves one after another; returns the generation at which each ends."""
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


def _before(stands_in: bool) -> str:
    return "undamaged simulator" if stands_in else "before the damage"


def _draw_trials(axes: Any, state: RunState, axis: str, ends: Sequence[int], before: str) -> None:
    if state.before is not None and state.trials:
        axes.plot(ends[0], state.before.distance(axis), "^", color=_BEFORE, label=before)
        axes.plot(ends[0], state.trials[0].distance(axis), "o", color=_DAMAGED, label="damaged")
    distances = [trial.distance(axis) for trial in state.trials[1:]]
    if distances:
        axes.plot(ends[1 : len(distances) + 1], distances, "s", color=_TRIAL, label="hardware trial", clip_on=False)


def _captions(diagnoses: Sequence[Sequence[Change]], letters: int) -> list[str]:
    """The diagnosis of each pass, wrapped to some letters a line; repeated diagnoses are shortened."""
    captions, previous = [], None
    for number, diagnosis in enumerate(diagnoses, start=1):
        sentences = [change.sentence() for change in diagnosis] or ["nothing differs"]
        text = "\n".join(fill(sentence, max(letters, 8)) for sentence in sentences)
        full = f"{number}: as before" if text == previous else f"{number}:\n{text}"
        captions.append(f"{number}" if letters < 8 else full)
        previous = text
    return captions
