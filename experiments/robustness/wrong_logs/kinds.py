"""Twenty ways in which a log is wrong in meaning, and by which faults `check` names each."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

Columns = dict[str, np.ndarray]


class Wrong(NamedTuple):
    """A way to be wrong.

    Attributes:
        make: a right log and a generator -> a wrong one.
        named: kinds of faults by which it counts as named.
    """

    make: Callable[[Columns, np.random.Generator], Columns]
    named: tuple[str, ...]


def _some(columns: Columns, draw: np.random.Generator, prefix: str, count: int = 1) -> list[str]:
    names = [name for name in columns if name.startswith(prefix)]
    return [names[int(k)] for k in draw.permutation(len(names))[:count]]


def _exchanged(prefix: str) -> Callable[[Columns, np.random.Generator], Columns]:
    def make(columns: Columns, draw: np.random.Generator) -> Columns:
        one, other = _some(columns, draw, prefix, 2)
        return columns | {one: columns[other], other: columns[one]}

    return make


def _changed(change: Callable[[np.ndarray, np.random.Generator], np.ndarray], prefix: str = "sensor.q"):  # noqa: ANN202
    def make(columns: Columns, draw: np.random.Generator) -> Columns:
        [name] = _some(columns, draw, prefix)
        return columns | {name: change(columns[name], draw)}

    return make


def _timed(change: Callable[[np.ndarray, np.random.Generator], np.ndarray]):  # noqa: ANN202
    return lambda columns, draw: columns | {"time": change(columns["time"], draw)}


def _noise(values: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    return draw.normal(float(values.mean()), float(values.std()), len(values))


def _stuck(values: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    first = int(draw.integers(len(values) // 4, len(values) // 2))
    return np.where(np.arange(len(values)) < first, values, values[first])


def _copies_command(columns: Columns, draw: np.random.Generator) -> Columns:
    [name] = _some(columns, draw, "sensor.q")
    return columns | {name: columns[f"ctrl.m{name.removeprefix('sensor.q')}"]}


def _copies_joint(columns: Columns, draw: np.random.Generator) -> Columns:
    one, other = _some(columns, draw, "sensor.q", 2)
    return columns | {one: columns[other]}


def _without(columns: Columns, count: int, draw: np.random.Generator) -> Columns:
    first = int(draw.integers(100, len(columns["time"]) - 200))
    return {name: np.delete(values, slice(first, first + count)) for name, values in columns.items()}


def _shuffled(columns: Columns, draw: np.random.Generator) -> Columns:
    order = draw.permutation(len(columns["time"]))
    return {name: values if name == "time" else values[order] for name, values in columns.items()}


def _reversed(columns: Columns, _: np.random.Generator) -> Columns:
    return {name: values if name == "time" else values[::-1] for name, values in columns.items()}


def _shifted(columns: Columns, seconds: float) -> Columns:
    """Commands as they are so many seconds later."""
    time = columns["time"]
    return {k: np.interp(time + seconds, time, v) if k.startswith("ctrl") else v for k, v in columns.items()}


def _sign(draw: np.random.Generator) -> float:
    return float(draw.choice([-1.0, 1.0]))


_SIGNAL = ("no_signal",)
KINDS: dict[str, Wrong] = {
    "readings exchanged": Wrong(_exchanged("sensor.q"), ("channels_exchanged",)),
    "commands exchanged": Wrong(_exchanged("ctrl.m"), ("channels_exchanged",)),
    "reading is noise": Wrong(_changed(_noise), _SIGNAL),
    "reading copies command": Wrong(_copies_command, _SIGNAL),
    "reading copies a joint": Wrong(_copies_joint, (*_SIGNAL, "channels_exchanged")),
    "offset of .3 rad": Wrong(_changed(lambda v, d: v + 0.3 * _sign(d)), ("offset", "beyond_limits")),
    "offset of a turn": Wrong(_changed(lambda v, d: v + 2.0 * np.pi * _sign(d)), ("offset", "beyond_limits")),
    "reading in degrees": Wrong(_changed(lambda v, d: np.degrees(v)), ("degrees",)),
    "reading in ticks": Wrong(_changed(lambda v, d: np.round(2048 + v / 2 / np.pi * 4096)), ("ticks",)),
    "reading with another sign": Wrong(_changed(lambda v, d: -v), ("sign",)),
    "stuck sensor": Wrong(_changed(_stuck), ("stuck", "still", "no_signal", "clipped", "stale")),
    "ten rows lost": Wrong(lambda c, d: _without(c, 10, d), ("clock_gap",)),
    "clock 10 % long": Wrong(_timed(lambda t, d: 1.1 * t), ("clock_scale",)),
    "clock 8 % short": Wrong(_timed(lambda t, d: 0.92 * t), ("clock_scale",)),
    "clock in ms": Wrong(_timed(lambda t, d: 1000.0 * t), ("time_unit",)),
    "commands 30 ms early": Wrong(lambda c, d: _shifted(c, 0.03), ("command_lead", "late")),
    "commands 30 ms late": Wrong(lambda c, d: _shifted(c, -0.03), ("command_lead", "ahead")),
    "rows shuffled": Wrong(_shuffled, (*_SIGNAL, "spikes", "clock_jitter")),
    "time reversed": Wrong(_reversed, ("ahead", "command_lead", "time_reversed", "sign")),
    "the test is a training log": Wrong(lambda c, d: c, ("copied_recording",)),
}
COPIED = "the test is a training log"
