"""Figures of a proposed motion: its commands, and the predictions of each explanation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from estexp_jax.experiment_design.propose import ProposedExperiment
from estexp_jax.report.channels import unit_of
from estexp_jax.report.drawing.axes import WIDTH, short
from estexp_jax.report.drawing.onto import new_figure
from estexp_jax.report.propose.text import propose_rows

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOURS = ("#1b6ca8", "#d95f02", "#1b9e77", "#7570b3", "#a6761d", "#666666")
_STYLES = ("-", "--", "-.", ":", (0, (5, 1)), (0, (1, 1)))
_MOST_MOTORS, _MOST_SENSORS = 8, 3


def figure_commands(proposed: ProposedExperiment) -> Figure:
    """The commands of the motors with the widest range, one panel each."""
    reach = np.ptp(proposed.commands, axis=0)
    chosen = sorted(np.argsort(-reach, kind="stable")[:_MOST_MOTORS])
    figure = new_figure(WIDTH, 0.9 + 0.95 * len(chosen))
    panels = figure.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0]
    for axes, motor in zip(panels, chosen, strict=True):
        axes.step(proposed.time, proposed.commands[:, motor], where="post", color=_COLOURS[0], lw=1.2)
        name = proposed.robot.command_columns()[motor]
        axes.set_title(short(name), fontsize=9, loc="left", parse_math=False)
        axes.spines[["top", "right"]].set_visible(False)
    panels[-1].set_xlabel("time (s)")
    figure.supylabel("command, in the motor's unit", fontsize=9)
    return figure


def figure_predictions(proposed: ProposedExperiment) -> Figure:
    """Predictions of each explanation for the readings on which pairs differ most, the best separated pairs first.

    Grey lines mark the times at which a pair differs most.
    """
    chosen = informative_readings(proposed)
    figure = new_figure(WIDTH, 1.1 + 2.0 * len(chosen))
    panels = figure.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (channel, times) in zip(panels, chosen.items(), strict=True):
        index = proposed.competing_models.channels.index(channel)
        for n, readings in enumerate(proposed.predicted.readings):
            style, colour = _STYLES[n % len(_STYLES)], _COLOURS[n % len(_COLOURS)]
            axes.plot(proposed.time, readings[:, index], ls=style, color=colour, lw=1.4, label=f"{n + 1}")
        for time_s in times:
            axes.axvline(time_s, color="0.75", lw=1.0, zorder=0)
        unit = unit_of(proposed.robot, channel)
        axes.set_ylabel(f"{short(channel, 24)}{f' ({unit})' if unit else ''}", parse_math=False)
        axes.spines[["top", "right"]].set_visible(False)
    panels[-1].set_xlabel("time (s)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=6, frameon=False, fontsize=9)
    return figure


def informative_readings(proposed: ProposedExperiment) -> dict[str, list[float]]:
    """The readings to plot, with the times (s) at which pairs differ most; the best separated pairs come first."""
    chosen: dict[str, list[float]] = {}
    for pair in sorted(propose_rows(proposed), key=lambda row: -np.nan_to_num(row["separation"])):
        if pair["sensor"] in chosen or len(chosen) < _MOST_SENSORS:
            times = chosen.setdefault(pair["sensor"], [])
            if pair["time"] not in times:
                times.append(pair["time"])
    return chosen
