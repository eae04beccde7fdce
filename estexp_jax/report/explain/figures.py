"""Figures of an explanation: places of the error, a test recording before and after, and the ranked explanations.

All are narrow and tall, so that their text stays readable on a phone.
"""

from __future__ import annotations

from textwrap import wrap
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from estexp_jax.errors import InputError, known
from estexp_jax.report.drawing.axes import (
    EXPLAINED,
    NOMINAL,
    OTHER,
    RECORDED,
    WIDTH,
    draw_noise_floor,
    label_rows,
    log_axis,
    short,
)
from estexp_jax.report.drawing.onto import new_figure
from estexp_jax.report.explain.text import place_name

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from estexp_jax.discovery.diagnosis import Diagnosis, Prediction
    from estexp_jax.discovery.selection import Explanation

_MAX_STRIPS = 16
"""How many channels of recordings are shown, those with the largest errors."""
_MAX_PLACES = 8
_MAX_CANDIDATES = 14
_LABEL_LETTERS = 30
"""Letters in one line of a label."""


class _Strip(NamedTuple):
    """Nominal error of one channel of one recording by window, as a share of the channel's range."""

    label: str
    edges: np.ndarray  # (windows + 1,) s
    error: np.ndarray  # (windows,)


def figure_where(diagnosis: Diagnosis) -> Figure:
    """The nominal simulator's error in each window of the training recordings, and the ranked places."""
    strips = _strips(diagnosis)
    places = diagnosis.findings["where"][:_MAX_PLACES]
    heights = [0.5 + 0.3 * len(strips), 0.35 + 0.3 * len(places)] if places else [0.5 + 0.3 * len(strips)]
    figure = new_figure(WIDTH, sum(heights) + 0.9 * len(heights))
    panels = figure.subplots(len(heights), 1, squeeze=False, gridspec_kw={"height_ratios": heights})[:, 0]
    _draw_strips(figure, panels[0], strips)
    if places:
        _draw_places(panels[1], places)
    return figure


def figure_fit(diagnosis: Diagnosis, reading: str | None = None, recording: str | None = None) -> Figure:
    """A recording before and after: one channel, and both simulators' errors.

    Args:
        diagnosis: what was found.
        reading: name of the channel; None: the one with the largest nominal error.
        recording: its file name; None: the test recording with the largest nominal error.

    Raises:
        InputError: there is none of that name, or it has no sample.
    """
    return figure_prediction(*worst_channel(diagnosis, reading, recording))


def figure_prediction(prediction: Prediction, channel: int) -> Figure:
    """One channel of a test recording under both simulators, and their errors."""
    time, breaks = with_breaks(prediction)
    recorded, nominal, explained = (
        np.insert(getattr(prediction, name)[:, channel].astype(float), breaks, np.nan)
        for name in ("recorded", "nominal", "explained")
    )
    figure = new_figure(WIDTH, 5.6)
    above, below = figure.subplots(2, 1, sharex=True, gridspec_kw={"height_ratios": [3, 2]})
    above.plot(time, recorded, color=RECORDED, lw=2.4, alpha=0.35, label="recorded")
    above.plot(time, nominal, color=NOMINAL, lw=1.2, label="nominal simulator")
    above.plot(time, explained, color=EXPLAINED, lw=1.2, ls="--", label="explained simulator")
    below.plot(time, nominal - recorded, color=NOMINAL, lw=1.1)
    below.plot(time, explained - recorded, color=EXPLAINED, lw=1.1)
    below.axhline(0.0, color="0.6", lw=0.8, zorder=0)
    for axes in (above, below):
        for start in prediction.time[np.flatnonzero(np.diff(prediction.window)) + 1]:
            axes.axvline(start, color="0.9", lw=0.8, zorder=0)
        axes.spines[["top", "right"]].set_visible(False)
    # File names may contain dollars, so mathematics is off.
    fitted = "never fitted" if prediction.role == "test" else "fitted"
    title = "\n".join(wrap(f"{prediction.recording}, {fitted}", 52))
    above.set_title(title, fontsize=10, loc="left", parse_math=False)
    above.set_ylabel("\n".join(wrap(prediction.channels[channel], 30)), parse_math=False)
    below.set_ylabel("simulated - recorded")
    below.set_xlabel("time (s); both restart at the pale lines")
    figure.legend(*above.get_legend_handles_labels(), loc="outside upper center", ncols=3, frameon=False, fontsize=9)
    return figure


def figure_ranking(diagnosis: Diagnosis) -> Figure:
    """All explanations by their error on held-out windows of the training recordings."""
    candidates = ranked(diagnosis)
    labels = ["\n".join(wrap(label, _LABEL_LETTERS)) for label, _ in candidates]
    lines = np.array([label.count("\n") + 1 for label in labels])
    figure = new_figure(WIDTH, 1.2 + 0.12 * len(candidates) + 0.16 * lines.sum())
    axes = figure.subplots()
    height = -np.cumsum([0.0, *(0.75 + 0.25 * (lines[:-1] + lines[1:]))])  # labels are centred at their rows
    chosen = diagnosis.selection.chosen
    for y, (_, explanation) in zip(height, candidates, strict=True):
        _draw_candidate(axes, y, explanation.error, _colour(diagnosis, explanation), bold=explanation is chosen)
    bold = [row for row, (_, explanation) in enumerate(candidates) if explanation is chosen]
    label_rows(axes, height.tolist(), labels, bold=bold)
    errors = [explanation.error for _, explanation in candidates]
    draw_noise_floor(axes, 1.0, errors)
    log_axis(axes, errors)
    axes.set_ylim(height[-1] - 0.5 - 0.5 * lines[-1], 0.5 + 0.5 * lines[0])
    axes.set_xlabel("error on held-out windows")
    return figure


def worst_channel(
    diagnosis: Diagnosis, reading: str | None = None, recording: str | None = None
) -> tuple[Prediction, int]:
    """The recording and channel with the largest nominal error relative to the channel's range; see `figure_fit`."""
    recordings = [p.recording for p in diagnosis.predictions]
    readings = list(dict.fromkeys(c for p in diagnosis.predictions for c in p.channels))
    for what, name, choices in (("recording", recording, recordings), ("reading", reading, readings)):
        if name is not None and name not in choices:
            raise InputError(f"there is no {what} '{name}'", where=f"{what}=", right=known(choices))
    errors = [
        (float(np.sqrt(np.mean(error**2))), i, channel)
        for i, p in enumerate(diagnosis.predictions)
        if (p.role == "test" if recording is None else p.recording == recording)
        for channel, error in enumerate(_normalised(p).T)
        if reading in (None, p.channels[channel])
        for error in [error[np.isfinite(error)]]
        if error.size
    ]
    if not errors:
        raise InputError("has no sample", where=" of ".join(filter(None, (reading, recording))), right=known(readings))
    _, i, channel = max(errors)
    return diagnosis.predictions[i], channel


def ranked(diagnosis: Diagnosis) -> list[tuple[str, Explanation]]:
    """Nominal, parameters only, then the best explanations, including the chosen one; each with its label."""
    selection = diagnosis.selection
    best = sorted(selection.tried, key=lambda e: e.error)[:_MAX_CANDIDATES]
    if selection.chosen in selection.tried and selection.chosen not in best:
        best[-1] = selection.chosen
    known = [("nominal simulator", selection.nominal), ("parameters only", selection.parameters)]
    return known + [(name_of(e), e) for e in best]


def name_of(explanation: Explanation) -> str:
    """`coulomb friction @ knee + armature @ knee`."""
    return " + ".join(e.replace("_", " ") + (f" @ {s}" if s else "") for e, s in explanation.places)


def _strips(diagnosis: Diagnosis) -> list[_Strip]:
    strips = []
    training = [p for p in diagnosis.predictions if p.role == "train"]
    for p in training:
        error = _normalised(p) ** 2
        firsts = np.flatnonzero(np.diff(p.window, prepend=-1))
        edges = np.append(p.time[firsts], p.time[-1])
        for channel, name in enumerate(p.channels):
            parts = [part[np.isfinite(part)] for part in np.split(error[:, channel], firsts[1:])]
            if any(part.size for part in parts):
                rms = np.array([np.sqrt(part.mean()) if part.size else np.nan for part in parts])
                strips.append(_Strip(f"{p.recording}\n{name}" if len(p.channels) > 1 else p.recording, edges, rms))
    if len(strips) <= _MAX_STRIPS:
        return strips
    least = sorted((float(np.nanmean(s.error)) for s in strips), reverse=True)[_MAX_STRIPS - 1]
    return [s for s in strips if np.nanmean(s.error) >= least][:_MAX_STRIPS]


def _normalised(prediction: Prediction) -> np.ndarray:
    """Nominal errors (rows, channels) relative to each channel's range; NaN where there is no sample."""
    table, bad = prediction.recorded, ~np.isfinite(prediction.recorded)
    span = np.max(np.where(bad, -np.inf, table), axis=0) - np.min(np.where(bad, np.inf, table), axis=0)
    return (prediction.nominal - table) / np.where(np.isfinite(span) & (span > 0.0), span, 1.0)


def _draw_strips(figure: Figure, axes: Axes, strips: list[_Strip]) -> None:
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    top = max([float(np.nanmax(s.error)) for s in strips], default=1.0) or 1.0
    colours = ScalarMappable(Normalize(0.0, 100.0 * top), "YlOrRd")
    for row, strip in enumerate(strips):
        for left, right, error in zip(strip.edges[:-1], strip.edges[1:], strip.error, strict=True):
            colour = colours.to_rgba(100.0 * error) if np.isfinite(error) else "#eeeeee"
            axes.barh(row, right - left, left=left, height=0.8, color=colour, edgecolor="white", linewidth=0.5)
    label_rows(axes, range(len(strips)), [short(s.label) for s in strips], fontsize=8)
    axes.set_ylim(len(strips) - 0.4, -0.6)
    axes.set_xlabel("time (s)")
    axes.set_title("Error of the nominal simulator,\ntraining recordings", fontsize=10, loc="left")
    figure.colorbar(colours, ax=axes, label="% of the range", fraction=0.05, pad=0.02)


def _draw_places(axes: Axes, places: list[dict[str, Any]]) -> None:
    shares = [100.0 * p["share"] for p in places]
    bars = axes.barh(range(len(places)), shares, height=0.6, color=[EXPLAINED] + [OTHER] * (len(places) - 1))
    axes.bar_label(bars, [f"{s:.0f} %" for s in shares], padding=4, fontsize=9)
    names = [short(place_name(p["kind"], p["name"])) for p in places]
    axes.set_yticks(range(len(places)), names, fontsize=9, parse_math=False)
    axes.set_ylim(len(places) - 0.4, -0.6)
    axes.set_xlim(0.0, max(shares) * 1.15)
    axes.set_title("Places, by the share of the error\nthat an effect there removes", fontsize=10, loc="left", pad=10)
    axes.set_xticks([])
    axes.spines[["top", "right", "bottom"]].set_visible(False)
    axes.tick_params(axis="y", length=0)


def _draw_candidate(axes: Axes, y: float, error: float, colour: str, *, bold: bool) -> None:
    axes.plot(error, y, "o", color=colour, markersize=9 if bold else 6)
    weight = "bold" if bold else "normal"
    offset = {"xytext": (9, 0), "textcoords": "offset points", "va": "center"}
    axes.annotate(f"{error:.3g}", (error, y), fontsize=8, color=colour, fontweight=weight, **offset)
    axes.axhline(y, color="0.93", lw=0.8, zorder=0)


def _colour(diagnosis: Diagnosis, explanation: Explanation) -> str:
    if explanation is diagnosis.selection.chosen:
        return EXPLAINED
    return NOMINAL if explanation is diagnosis.selection.nominal else OTHER


def with_breaks(prediction: Prediction) -> tuple[np.ndarray, np.ndarray]:
    """Times (rows + windows - 1,) with a NaN before each window but the first, and the indices of the NaNs."""
    breaks = np.flatnonzero(np.diff(prediction.window)) + 1
    return np.insert(prediction.time.astype(float), breaks, np.nan), breaks
