"""The unit that a clock is likely in, by its numbers."""

from __future__ import annotations

import math

import numpy as np

CLOCK_UNITS = ("ms", "us", "ns")
"""Units of clocks besides s."""
_PER_S = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}
_SINCE_1970_S = (9.4e8, 4.2e9)  # 2000 to 2100
_PERIODS_S, _USUAL_S = (1e-4, 0.5), 5e-3


def likely_clock_unit(times: np.ndarray) -> str:
    """The unit of a log's times (rows,), if it is likely not s; else empty.

    Times since 1970 tell it by their size. Of others, the period of rows does: robots log at 2 Hz to 10 kHz.
    """
    times = times[np.isfinite(times)]
    steps = np.diff(times)
    steps = steps[steps > 0.0]
    if not len(steps):
        return ""
    first, period = float(abs(times[0])), float(np.median(steps))
    for unit, factor in _PER_S.items():
        if _SINCE_1970_S[0] < first / factor < _SINCE_1970_S[1]:
            return "" if unit == "s" else unit
    if period < _PERIODS_S[1]:
        return ""
    fitting = [unit for unit in CLOCK_UNITS if _PERIODS_S[0] <= period / _PER_S[unit] < _PERIODS_S[1]]
    distances = {unit: abs(math.log(period / _PER_S[unit] / _USUAL_S)) for unit in fitting}
    return min(distances, key=distances.__getitem__, default="")
