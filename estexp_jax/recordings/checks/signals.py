"""Properties of single signals: encoder steps, repeats, runs, spikes, lags. All arrays are without gaps."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

_NEIGHBOURS = 5
_MOST_POINTS, _MOST_SHIFTS = 20_000, 500


@final
@dataclass(frozen=True)
class Run:
    """Consecutive samples with the same value.

    Attributes:
        start: index of the first sample.
        length: number of samples.
    """

    start: int
    length: int

    @property
    def stop(self) -> int:
        """Index after the last sample."""
        return self.start + self.length


def encoder_step(values: np.ndarray) -> float:
    """The largest step that divides all differences, in the values' unit; 0.0 if there is none."""
    levels = np.unique(values)
    steps = np.diff(levels)
    if len(levels) < 3:
        return 0.0
    steps = steps[steps > 1e-9 * float(np.ptp(levels))]
    smallest = float(steps.min())
    small = steps[steps < 20.0 * smallest] / smallest  # larger steps accumulate the rounding of the log's digits
    whole = np.abs(small - np.round(small)) < 0.05
    return smallest if whole.mean() > 0.99 and len(levels) < 0.9 * len(values) else 0.0


def repeats(values: np.ndarray, step: float) -> float:
    """Share of samples equal to the one before, where the signal moves faster than its encoder steps explain."""
    n = _NEIGHBOURS
    if len(values) < 8 * n:
        return 0.0
    travel = np.minimum(np.abs(values[2 * n :] - values[n:-n]), np.abs(values[n:-n] - values[: -2 * n]))
    moving = travel > max(1.4 * n * step, 1e-9, 0.02 * float(np.ptp(values)))
    same = (np.diff(values) == 0.0)[n - 1 : n - 1 + len(moving)]
    return float(same[moving].mean()) if moving.sum() >= 4 * n else 0.0


def runs(values: np.ndarray, shortest: int) -> list[Run]:
    """Runs of at least `shortest` equal samples."""
    edges = np.flatnonzero(np.diff(values) != 0.0) + 1
    firsts = np.concatenate([[0], edges])
    lengths = np.diff(np.concatenate([firsts, [len(values)]]))
    pairs = zip(firsts.tolist(), lengths.tolist(), strict=True)
    return [Run(start, length) for start, length in pairs if length >= shortest]


def clipped(values: np.ndarray) -> tuple[float, float]:
    """The value at which a signal is clipped, and the share of samples there; (nan, 0.0) if it is not clipped.

    A motion that reverses by itself slows down first. A clipped signal reaches its largest value at speed, over several
    encoder steps a sample. A slower signal may be held there by friction.
    """
    step = encoder_step(values)
    pace = np.abs(np.diff(values))
    typical = float(np.percentile(pace[pace > 0.0], 70)) if (pace > 0.0).any() else 0.0
    worst = (float("nan"), 0.0)
    for end in (float(values.max()), float(values.min())):
        hit = [run for run in runs(values, 5) if values[run.start] == end and run.start > 3]
        fast = [run for run in hit if np.median(pace[run.start - 3 : run.start]) > max(0.5 * typical, 2.5 * step)]
        share = sum(run.length for run in fast) / len(values)
        if len(fast) >= 2 and share > max(0.04, worst[1]):
            worst = (end, share)
    return worst


def spikes(values: np.ndarray, step: float) -> np.ndarray:
    """Indices of samples that jump away from their neighbours and back."""
    if len(values) < 4 * _NEIGHBOURS:
        return np.empty(0, dtype=int)
    padded = np.pad(values, 2, mode="edge")
    middle = np.median(np.lib.stride_tricks.sliding_window_view(padded, 5), axis=1)
    off = np.abs(values - middle)
    least = max(10.0 * float(np.percentile(off, 98)), 4.0 * step, 0.1 * float(np.ptp(middle)), 1e-9)
    back = np.abs(padded[3:-1] - padded[1:-3])
    outliers = np.flatnonzero((off > least) & (back < 0.3 * off))
    return outliers if len(outliers) <= 0.02 * len(values) else np.empty(0, dtype=int)


def slope_agreement(first: np.ndarray, second: np.ndarray) -> float:
    """Correlation of two signals, -1 to 1; 0.0 where one does not move."""
    a, b = first - first.mean(), second - second.mean()
    size = float(np.sqrt((a @ a) * (b @ b)))
    return float(a @ b) / size if size > 1e-12 else 0.0


def lag(time: np.ndarray, cause: np.ndarray, effect: np.ndarray, max_lag: float = 0.5) -> tuple[float, float, float]:
    """Delay of one signal behind another.

    Args:
        time: (n,) s, increasing.
        cause: (n,) the signal that should come first.
        effect: (n,) the other signal.
        max_lag: largest lag, s, in either direction.

    Returns:
        The lag of highest correlation, s; that correlation; the correlation without a lag.
    """
    period = max(float(np.median(np.diff(time))), float(time[-1] - time[0]) / _MOST_POINTS, max_lag / _MOST_SHIFTS)
    grid = np.arange(time[0], time[-1], period)
    a, b = np.interp(grid, time, cause), np.interp(grid, time, effect)
    most_shifts = min(int(max_lag / period), len(grid) // 4)
    if most_shifts < 1:
        return 0.0, 0.0, 0.0
    shifts = range(-most_shifts, most_shifts + 1)
    pairs = ((a[: len(a) - k], b[k:]) if k >= 0 else (a[-k:], b[:k]) for k in shifts)
    correlations = [slope_agreement(*pair) for pair in pairs]
    best = int(np.argmax(correlations))
    return shifts[best] * period, correlations[best], correlations[most_shifts]


def speed(time: np.ndarray, values: np.ndarray) -> np.ndarray:
    """The slope of a signal over a few samples around each, since single differences show the encoder's steps."""
    width = min(2, (len(values) - 1) // 2)
    if width < 1:
        return np.gradient(values, time)
    slope = (values[2 * width :] - values[: -2 * width]) / (time[2 * width :] - time[: -2 * width])
    return np.pad(slope, width, mode="edge")


def turns(values: np.ndarray, smallest: float) -> int:
    """How often a signal reverses, counting swings larger than `smallest`."""
    count, direction, extreme = 0, 0, float(values[0])
    for value in values.tolist():
        ahead = (value - extreme) * (direction or 1)
        if direction == 0 and abs(value - extreme) > smallest:
            direction, extreme = (1 if value > extreme else -1), value
        elif direction and ahead > 0.0:
            extreme = value
        elif direction and -ahead > smallest:
            count, direction, extreme = count + 1, -direction, value
    return count
