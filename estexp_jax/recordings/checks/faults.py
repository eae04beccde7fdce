"""Faults of recordings that can be found without a simulation, each with its place and a remedy."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from estexp_jax.recordings.checks import signals
from estexp_jax.recordings.checks.clock_units import likely_clock_unit

FULL_TURNS = 4.0 * math.pi
"""A hinge angle above this, rad, is more likely in degrees than beyond two turns."""
UNEVEN = 0.25
"""Standard deviation of the clock's period, as a share of it, above which the clock counts as uneven."""
STALE = 0.4
"""Share of repeated samples in a moving signal above which it counts as sampled too slowly."""


@final
@dataclass(frozen=True)
class Fault:
    """A fault, certain or suspected.

    Attributes:
        kind: identifier, such as `clock_gap`.
        name: the column, actuator or joint; `time` for the clock.
        sentence: observation and remedy.
    """

    kind: str
    name: str
    sentence: str


def clock_faults(clock: Mapping[str, Any], times: np.ndarray) -> Iterator[Fault]:
    """A clock in a wrong unit, uneven, or with gaps.

    Args:
        clock: as `judge` gives it.
        times: (rows,) s.
    """
    period, unit = clock["period_s"], likely_clock_unit(times)
    if unit or period >= 0.5 or period < 1e-6:
        what = f"rows are {period:.3g} s apart; is the clock in another unit?"
        yield Fault("time_unit", "time", f'{what} Give it: unit = "{unit}"' if unit else f"{what} Give its scale")
    often = clock["gaps"] > 0.05 * clock["steps"]
    if clock["gaps"] and not often:
        first = clock["gap_list"][0]
        what = f"{clock['gaps']} gaps, the longest {clock['longest_s']:.3g} s, the first at {first['time_s']:.4g} s"
        yield Fault("clock_gap", "time", f"{what}; what happened in them is guessed: log without pauses, or cut there")
    if often or clock["jitter_s"] > UNEVEN * period:
        what = f"the clock is uneven: periods of {clock['shortest_s']:.3g} to {clock['longest_s']:.3g} s"
        yield Fault("clock_jitter", "time", f"{what}; stamp each row when it is sampled, not when it is written")


def reading_faults(name: str, kind: str, time: np.ndarray, values: np.ndarray, rows: np.ndarray) -> Iterator[Fault]:
    """Faults of a single reading.

    Args:
        name: our column.
        kind: `angle`, `length`, `speed`, or empty if it is not a joint's.
        time: (n,) of its samples, s.
        values: (n,) samples.
        rows: (n,) their rows.
    """
    if len(values) < 2:
        return
    step, span = signals.encoder_step(values), float(np.ptp(values))
    row_steps = np.diff(rows)
    dropouts = np.flatnonzero(row_steps > max(3.0 * float(np.median(row_steps)), 3.0))
    if len(dropouts):
        longest = float(np.max(time[dropouts + 1] - time[dropouts]))
        first = float(time[dropouts[0]])
        what = f"{len(dropouts)} gaps without a sample, the first at {first:.4g} s, the longest {longest:.3g} s"
        yield Fault("dropouts", name, f"{what}; see whether the sensor or its bus drops out")
    stale = signals.repeats(values, step)
    if stale > STALE:
        what = (
            f"repeats the reading before in {stale:.0%} of the rows while it moves: it is read less often than logged"
        )
        yield Fault("stale", name, f"{what}; leave the cell empty where there is no new sample")
    if kind in ("angle", "length"):
        if step > span / 50.0 and span > 0.0:
            what = f"moves over {span / step:.0f} steps of its encoder of {step:.3g} each"
            yield Fault("coarse_encoder", name, f"{what}; move further, or small effects drown in them")
        outliers = signals.spikes(values, step)
        if len(outliers):
            what = f"{len(outliers)} single readings jump away and back, the first at {time[outliers[0]]:.4g} s"
            yield Fault("spikes", name, f"{what}; empty these cells, a bus error is no motion")
    if stale <= STALE:
        end, share = signals.clipped(values)
        if share:
            what = f"is cut off at {end:.4g} in {share:.0%} of the rows"
            yield Fault("clipped", name, f"{what}: the sensor's range, or a stop; widen the range, or move less far")


def unit_faults(name: str, values: np.ndarray) -> Iterator[Fault]:
    """An angle so large that its unit is probably not rad."""
    largest = float(np.abs(values).max(initial=0.0))
    if largest <= FULL_TURNS:
        return
    if largest > 100.0 and len(np.unique(values)) > 2 and (values == np.round(values)).all():
        what = f"whole numbers up to {largest:.4g}: raw encoder ticks?"
        yield Fault("ticks", name, f"{what} Give their scale, such as 2 pi / 4096 = 0.0015339808, and the offset")
    else:
        yield Fault("degrees", name, f'reaches {largest:.4g} rad; is it in degrees? Then give unit = "deg"')


def speed_faults(time: np.ndarray, columns: Mapping[str, str], readings: Mapping[str, np.ndarray]) -> Iterator[Fault]:
    """Faults of a joint's speed compared with the slope of its position.

    Args:
        time: (rows,) s.
        columns: that measure the joint's motion, each with its kind.
        readings: (rows,) of each column.
    """
    position = next((column for column, kind in columns.items() if kind != "speed"), None)
    rate = next((column for column, kind in columns.items() if kind == "speed"), None)
    if position is not None and rate is not None:
        rows = np.isfinite(readings[position]) & np.isfinite(readings[rate])
        yield from slope_faults(position, rate, time[rows], readings[position][rows], readings[rate][rows])


def slope_faults(angle: str, rate: str, time: np.ndarray, values: np.ndarray, speeds: np.ndarray) -> Iterator[Fault]:
    """A speed that is not the slope of the angle: wrong unit or sign.

    Args:
        angle: our column of the angle.
        rate: our column of the speed.
        time: (n,) s, rows at which both have samples.
        values: (n,) the angle.
        speeds: (n,) the speed.
    """
    if len(time) < 20:
        return
    slope = signals.speed(time, values)
    if abs(signals.slope_agreement(slope, speeds)) < 0.8:
        return
    ratio = float(np.std(speeds) / max(np.std(slope), 1e-300))
    sign = "-" if signals.slope_agreement(slope, speeds) < 0.0 else ""
    if sign or not 0.6 < ratio < 1.6:
        what = f"is {sign}{ratio:.3g} times the slope of {angle}"
        yield Fault("speed_unit", rate, f"{what}; give its unit (deg/s, rpm) or scale, or mend the angle's")
