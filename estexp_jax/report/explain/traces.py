"""Every reading of every recording beside both simulators, for the figure in which a reader chooses among them."""

from __future__ import annotations

import base64
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from estexp_jax.report.channels import unit_of
from estexp_jax.report.explain.figures import with_breaks, worst_channel
from estexp_jax.report.pages import format_number, percent

if TYPE_CHECKING:
    from estexp_jax.discovery.diagnosis import Diagnosis, Prediction
    from estexp_jax.physics.model.robot import Robot

SERIES = ("recorded", "nominal", "explained")
_MOST_VALUES = 900_000
"""Of all recordings together: 2.4 MB of a page. Of more, every second row is shown, or every third, ..."""
_LEVELS, _NO_SAMPLE = 32_000, -32_768
"""Readings are drawn as whole numbers of so many levels, and one that says that there is no sample."""
_FOLDER = Path(__file__).parent


def traces_script() -> str:
    """The program that draws them, after the library that it uses, with the library's licence."""
    files = (
        _FOLDER.parent / "uplot" / "LICENSE",
        _FOLDER.parent / "uplot" / "uPlot.iife.min.js",
        _FOLDER / "traces.js",
    )
    licence, library, own = (path.read_text(encoding="utf-8") for path in files)
    return f"/*\n{licence}*/\n{library}\n{own}"


def traces_style() -> str:
    """The library's style sheet."""
    return (_FOLDER.parent / "uplot" / "uPlot.min.css").read_text(encoding="utf-8")


def traces(diagnosis: Diagnosis) -> dict[str, Any]:
    """What the page draws, as plain JSON: test recordings first, and which reading is shown at first.

    Times are base64 of single precision; readings are base64 of 16-bit numbers from `low` on, in steps of `step`.
    """
    predictions = sorted(diagnosis.predictions, key=lambda p: p.role != "test")
    every = max(math.ceil(sum(len(SERIES) * p.recorded.size for p in predictions) / _MOST_VALUES), 1)
    worst, channel = worst_channel(diagnosis)
    return {
        "every": every,
        "first": [predictions.index(worst), channel],
        "recordings": [_recording(p, diagnosis.case.robot, every) for p in predictions],
    }


def _recording(p: Prediction, robot: Robot, every: int) -> dict[str, Any]:
    time, breaks = with_breaks(p)
    empty = np.flatnonzero(np.isnan(time))
    time[empty] = 0.5 * (time[empty - 1] + time[empty + 1])
    kept = np.unique(np.concatenate([np.arange(0, len(time), every), empty]))  # a gap where a window begins
    return {
        "name": p.recording,
        "role": p.role,
        "time": _packed(time[kept].astype("<f4")),
        "readings": [_reading(p, robot, i, breaks, kept) for i in range(len(p.channels))],
    }


def _reading(p: Prediction, robot: Robot, i: int, breaks: np.ndarray, kept: np.ndarray) -> dict[str, Any]:
    unit = unit_of(robot, p.channels[i])
    series = [np.insert(getattr(p, name)[:, i].astype(float), breaks, np.nan)[kept] for name in SERIES]
    known = np.concatenate([s[np.isfinite(s)] for s in series])
    low, high = (float(known.min()), float(known.max())) if known.size else (0.0, 0.0)
    step = (high - low) / _LEVELS or 1.0
    return {
        "name": p.channels[i],
        "unit": unit,
        "low": low,
        "step": step,
        "values": [_packed(_levels(s, low, step)) for s in series],
        "errors": _errors(p.recorded[:, i], p.nominal[:, i], p.explained[:, i], unit),
    }


def _levels(values: np.ndarray, low: float, step: float) -> np.ndarray:
    known = np.isfinite(values)
    return np.where(known, np.rint((np.where(known, values, low) - low) / step), _NO_SAMPLE).astype("<i2")


def _packed(values: np.ndarray) -> str:
    return base64.b64encode(values.tobytes()).decode()


def _errors(recorded: np.ndarray, nominal: np.ndarray, explained: np.ndarray, unit: str) -> str:
    """Both simulators' errors of a reading, as a share of its range and in its unit."""
    known = np.isfinite(recorded)
    if not known.any():
        return "No sample."
    span = float(np.ptp(recorded[known]))
    sizes = [float(np.sqrt(np.nanmean((one - recorded)[known] ** 2))) for one in (nominal, explained)]
    before, after = (in_unit(size, span, unit) for size in sizes)
    return f"Nominal simulator off by {before}, explained simulator by {after} (root mean square)."


def in_unit(size: float, span: float, unit: str) -> str:
    """An error as a share of a range and in its unit, angles in degrees: `0.9 % = 0.5 deg`."""
    degrees = {"rad": "deg", "rad/s": "deg/s"}
    number = format_number(math.degrees(size) if unit in degrees else size, 2)
    measure = f"{number} {degrees.get(unit, unit)}".rstrip()
    return f"{percent(size / span)} = {measure}" if span > 0.0 else measure
