"""The figure of `estexp check`: commands and readings over time."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from estexp_jax.physics.model.actuators import actuator_of_input
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.checks.inspect import GAP
from estexp_jax.runs.files import replacing

if TYPE_CHECKING:
    from matplotlib.axes import Axes

MOST_ROWS, MOST_COLUMNS = 24, 8
"""Channels and recordings that are drawn; the figure says how many are not."""

_COMMAND, _READING, _MISSING, _OFF = "#1f5fa8", "#333333", "#e0483e", "#999999"


def draw_check(robot: Robot, recordings: Sequence[Recording], path: Path) -> None:
    """Draw one row of axes a channel, one column a recording; gaps of the clock red, motors off grey.

    Args:
        robot: whose recordings they are.
        recordings: at least one.
        path: the file; its extension decides the format.
    """
    from matplotlib.figure import Figure

    drawn = list(recordings[:MOST_COLUMNS])
    channels, owners = _channels(robot, drawn), actuator_of_input(robot.model)
    rows = channels[:MOST_ROWS]
    figure = Figure(figsize=(3.2 + 3.0 * len(drawn), 1.0 + 1.1 * len(rows)), layout="constrained")
    grid = figure.subplots(len(rows), len(drawn), sharex="col", sharey="row", squeeze=False)
    for column, recording in enumerate(drawn):
        for row, (kind, index, name) in enumerate(rows):
            _draw_channel(grid[row, column], recording, kind, index, owners)
            if column == 0:
                # Names are not formulas, though they may have dollars in them.
                grid[row, column].set_ylabel(name, rotation=0, ha="right", va="center", fontsize=8, parse_math=False)
        grid[0, column].set_title(f"{recording.name} ({recording.role})", fontsize=9, parse_math=False)
        grid[-1, column].set_xlabel("time, s", fontsize=8)
    figure.suptitle(_title(len(channels) - len(rows), len(recordings) - len(drawn)), fontsize=9)
    with replacing(path) as stream:
        figure.savefig(stream, format=path.suffix.removeprefix("."), dpi=110)


def _channels(robot: Robot, recordings: Sequence[Recording]) -> list[tuple[str, int, str]]:
    """Array, column in it and name of each channel: all commands, and readings with samples in some recording."""
    channels = [("ctrl", index, f"ctrl.{name}") for index, name in enumerate(robot.command_columns())]
    names = {"sensor": [f"sensor.{name}" for name in robot.sensor_columns()]}
    names |= {kind: [f"{kind} {k}" for k in range(getattr(recordings[0], kind).shape[1])] for kind in ("qpos", "qvel")}
    for kind, columns in names.items():
        for index, name in enumerate(columns):
            if any(np.isfinite(getattr(recording, kind)[:, index]).any() for recording in recordings):
                channels.append((kind, index, name))
    return channels


def _draw_channel(axes: Axes, recording: Recording, kind: str, index: int, owners: np.ndarray) -> None:
    time, values = recording.time, getattr(recording, kind)[:, index]
    axes.tick_params(labelsize=7)
    axes.margins(x=0.01)
    if kind == "ctrl":
        axes.step(time, values, where="post", color=_COMMAND, linewidth=0.8)
        _shade_off(axes, time, recording.enable[:, owners[index]])
    else:
        finite = np.isfinite(values)
        # Rows without a sample are skipped: a slow sensor would otherwise be a row of invisible points.
        axes.plot(time[finite], values[finite], color=_READING, linewidth=0.8)
    for start in np.flatnonzero(np.diff(time) > GAP * np.median(np.diff(time))):
        axes.axvspan(time[start], time[start + 1], color=_MISSING, alpha=0.3, linewidth=0.0)


def _shade_off(axes: Axes, time: np.ndarray, enable: np.ndarray) -> None:
    off = np.concatenate([[False], enable == 0.0, [False]])
    first_rows, ends = np.flatnonzero(~off[:-1] & off[1:]), np.flatnonzero(off[:-1] & ~off[1:])
    for start, end in zip(first_rows, ends, strict=True):
        axes.axvspan(time[start], time[min(end, len(time) - 1)], color=_OFF, alpha=0.3, linewidth=0.0)


def _title(channels: int, recordings: int) -> str:
    left_out = [f"{n} more {what}" for n, what in ((channels, "channels"), (recordings, "recordings")) if n]
    hidden = f"; not shown: {' and '.join(left_out)}" if left_out else ""
    return f"commands blue, readings black; red: gaps of the clock, grey: motor off{hidden}"
