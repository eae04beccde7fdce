"""Errors of a simulation against recordings: normalised error, excess over noise, gain."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np


def nrmse(square_errors: Sequence[np.ndarray]) -> float:
    """Root mean square of normalised errors over sensors and recordings; NaN without any sample.

    Args:
        square_errors: for each recording (rows, channels) of squared errors over the channel's squared range, NaN where
            there is no sample.
    """
    parts = [np.nanmean(e[:, c]) for e in square_errors for c in range(e.shape[1]) if np.isfinite(e[:, c]).any()]
    return float(np.sqrt(np.mean(parts))) if parts else float("nan")


def excess(error: float, floor: float) -> float:
    """Error beyond what noise gives: sqrt(max(error^2 - floor^2, 0))."""
    return float(np.sqrt(max(error**2 - floor**2, 0.0)))


def gain(explained: float, nominal: float, floor: float) -> float:
    """Share of the nominal simulator's excess error that an explanation removes; NaN if there is no excess."""
    before = excess(nominal, floor)
    return 1.0 - excess(explained, floor) / before if before > 0.0 else float("nan")
