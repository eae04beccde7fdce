"""Whether commands and readings were stamped by one clock: no joint moves before its command, and no lag grows."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from estexp_jax.recordings.checks import signals
from estexp_jax.recordings.checks.faults import Fault

_REST_S, _BEFORE_S = 0.2, 0.15
"""How long a command rests before it counts as one that starts a motion, and how early a motion is looked for."""
_WINDOW_S, _FEWEST_WINDOWS, _MOST_WINDOWS = 4.0, 4, 20
_LEAST_DRIFT, _LEAST_CHANGE_S = 2e-4, 0.04
"""Of a lag that grows: per second, and over a recording; below, friction and heat change lags as well."""


def agreement_faults(name: str, time: np.ndarray, command: np.ndarray, reading: np.ndarray) -> Iterator[Fault]:
    """A reading that is stamped before what caused it, or by a clock that runs at another rate.

    Args:
        name: our column of the reading.
        time: (n,) s.
        command: (n,) position commanded to a servo.
        reading: (n,) position of its joint.
    """
    early = moves_before_commands(time, command, reading)
    if early > 0.0:
        what = f"begins to move {early:.2g} s before its command does: its stamps are early, or the command's late"
        yield Fault("ahead", name, f"{what}; stamp both by one clock, or shift one by what is known of its delay")
    drift, change = lag_drift(time, command, reading)
    if drift:
        faster = "reading's clock runs fast" if drift > 0.0 else "command's clock runs fast"
        what = f"its lag behind the command changes by {change:.2g} s in the recording, steadily: the {faster}"
        remedy = f"stamp both by one clock, or divide that one's times by {1 + abs(drift):.5g}"
        yield Fault("clock_drift", name, f"{what} by {abs(drift):.2g} s a second; {remedy}")


def moves_before_commands(time: np.ndarray, command: np.ndarray, reading: np.ndarray) -> float:
    """How long before its command a joint at rest begins to move, s, in most of its starts; 0.0 if it does not."""
    period = float(np.median(np.diff(time)))
    changes = np.flatnonzero(np.abs(np.diff(command)) > 1e-9 * max(float(np.ptp(command)), 1e-12)) + 1
    rests = np.diff(time[changes], prepend=time[0])
    onsets = changes[(rests > _REST_S) & (changes < len(time) - 1)]
    leads: list[float] = []
    for row in onsets.tolist():
        before = slice(
            int(np.searchsorted(time, time[row] - _REST_S)), int(np.searchsorted(time, time[row] - _BEFORE_S))
        )
        calm, near = reading[before], reading[before.stop : row]
        if len(calm) < 3 or len(near) < 3:
            continue
        step = signals.encoder_step(reading)
        least = max(3.0 * step, 6.0 * float(np.std(calm)), 1e-3 * float(np.ptp(reading)))
        if float(np.ptp(calm)) > least:  # not at rest yet
            continue
        settled = reading[int(np.searchsorted(time, time[row] - 2.0 * _REST_S)) : before.stop]
        if float(np.ptp(settled)) > least:  # what creeps or swings goes on to do so: no sign of an early start
            leads.append(0.0)
            continue
        away = np.sign(command[row] - command[row - 1]) * (near - np.median(calm)) > least
        still = np.flatnonzero(~away)
        first = before.stop + (int(still[-1]) + 1 if len(still) else 0)
        leads.append(float(time[row] - time[first]) if first < row else 0.0)
    lead = float(np.median(leads)) if leads else 0.0
    return lead if lead > max(0.005, 1.5 * period) else 0.0


def lag_drift(time: np.ndarray, command: np.ndarray, reading: np.ndarray) -> tuple[float, float]:
    """How fast a reading's lag behind its command grows, s/s, and by how much in all, s; zeros if it does not."""
    duration = float(time[-1] - time[0])
    count = min(int(duration / _WINDOW_S), _MOST_WINDOWS)
    if count < _FEWEST_WINDOWS:
        return 0.0, 0.0
    middles, lags = [], []
    edges = np.searchsorted(time, np.linspace(time[0], time[-1], count + 1))
    for first, last in zip(edges[:-1], edges[1:], strict=True):
        part = slice(int(first), int(last))
        if last - first < 20 or np.ptp(command[part]) < 0.1 * np.ptp(command):
            continue
        lag_s, correlation, _ = signals.lag(time[part], command[part], reading[part])
        if correlation > 0.9:
            middles.append(float(np.mean(time[part])))
            lags.append(lag_s)
    if len(lags) < _FEWEST_WINDOWS:
        return 0.0, 0.0
    # Theil and Sen: the median of the slopes of all pairs, which single wrong lags do not move.
    one, two = np.triu_indices(len(lags), 1)
    t, lag = np.array(middles), np.array(lags)
    pair_slopes = (lag[two] - lag[one]) / (t[two] - t[one])
    drift = float(np.median(pair_slopes))
    scatter = float(np.median(np.abs(lag - np.median(lag) - drift * (t - np.median(t)))))
    change = abs(drift) * duration
    agreeing = float(np.mean(np.sign(pair_slopes) == np.sign(drift)))
    if abs(drift) < _LEAST_DRIFT or change < max(_LEAST_CHANGE_S, 4.0 * scatter) or agreeing < 0.85:
        return 0.0, 0.0
    return drift, change
