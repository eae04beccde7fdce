"""Figures of a proposed motion: its commands, and what each explanation predicts where they differ most."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from estexp_jax.experiment_design.propose import ProposedExperiment
from estexp_jax.report.drawing.axes import short
from estexp_jax.report.propose.text import propose_rows, unit_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_WIDTH = 5.4
_COLOURS = ("#1b6ca8", "#d95f02", "#1b9e77", "#7570b3", "#a6761d", "#666666")
_STYLES = ("-", "--", "-.", ":", (0, (5, 1)), (0, (1, 1)))
_MOST_MOTORS, _MOST_SENSORS = 8, 3


def figure_commands(proposed: ProposedExperiment) -> Figure:
    """The commands, those of the motors that move most, one panel each."""
    from matplotlib.figure import Figure

    reach = np.ptp(proposed.commands, axis=0)
    chosen = sorted(np.argsort(-reach, kind="stable")[:_MOST_MOTORS])
    figure = Figure(figsize=(_WIDTH, 0.9 + 0.95 * len(chosen)), layout="constrained")
    panels = figure.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0]
    for axes, motor in zip(panels, chosen, strict=True):
        axes.step(proposed.time, proposed.commands[:, motor], where="post", color=_COLOURS[0], lw=1.2)
        name = proposed.robot.names("actuator")[motor]
        axes.set_title(short(name), fontsize=9, loc="left", parse_math=False)
        axes.spines[["top", "right"]].set_visible(False)
    panels[-1].set_xlabel("time (s)")
    figure.supylabel("command, in the motor's unit", fontsize=9)
    return figure


def figure_predictions(proposed: ProposedExperiment) -> Figure:
    """What each explanation predicts of the readings on which pairs of them differ most, those apart most first.

    A grey line marks the moment at which a pair differs most.
    """
    from matplotlib.figure import Figure

    chosen = informative_readings(proposed)
    figure = Figure(figsize=(_WIDTH, 1.1 + 2.0 * len(chosen)), layout="constrained")
    panels = figure.subplots(len(chosen), 1, sharex=True, squeeze=False)[:, 0]
    for axes, (channel, moments) in zip(panels, chosen.items(), strict=True):
        index = proposed.competing_models.channels.index(channel)
        for n, readings in enumerate(proposed.predicted.readings):
            style, colour = _STYLES[n % len(_STYLES)], _COLOURS[n % len(_COLOURS)]
            axes.plot(proposed.time, readings[:, index], ls=style, color=colour, lw=1.4, label=f"{n + 1}")
        for moment in moments:
            axes.axvline(moment, color="0.75", lw=1.0, zorder=0)
        unit = unit_of(proposed.robot, channel)
        axes.set_ylabel(f"{short(channel, 24)}{f' ({unit})' if unit else ''}", parse_math=False)
        axes.spines[["top", "right"]].set_visible(False)
    panels[-1].set_xlabel("time (s)")
    handles, labels = panels[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=6, frameon=False, fontsize=9)
    return figure


def informative_readings(proposed: ProposedExperiment) -> dict[str, list[float]]:
    """The readings to look at, with the moments (s) at which pairs differ most there; pairs apart most come first."""
    found: dict[str, list[float]] = {}
    for pair in sorted(propose_rows(proposed), key=lambda pair: -np.nan_to_num(pair["separation"])):
        if pair["sensor"] in found or len(found) < _MOST_SENSORS:
            moments = found.setdefault(pair["sensor"], [])
            if pair["time"] not in moments:
                moments.append(pair["time"])
    return found
