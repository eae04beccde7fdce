"""Noise of readings, estimated from the recording alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.estimation.channels import Channels, channel_ranges
from estexp_jax.physics.reading_noise import noise_std_of
from estexp_jax.physics.recording import Recording

_SPAN = 9


def correlation_rows(residuals: np.ndarray) -> float:
    """Integrated autocorrelation time of residuals in rows: so many count as one independent sample.

    The autocorrelation is summed over lags up to where it first falls under 0.05; white noise gives 1.

    Source: Sokal, Monte Carlo Methods in Statistical Mechanics (1997), section 3.

    Args:
        residuals: (windows, rows, channels), 0 where there is no sample.
    """
    rows = residuals.shape[1]
    spectrum = np.fft.rfft(residuals.astype(np.float64), 2 * rows, axis=1)
    covariance = np.fft.irfft(np.abs(spectrum) ** 2, axis=1)[:, :rows].sum(axis=(0, 2))
    if covariance[0] <= 0.0:
        return 1.0
    correlation = covariance / covariance[0]
    small = np.flatnonzero(correlation < 0.05)
    return float(1.0 + 2.0 * correlation[1 : int(small[0]) if len(small) else rows].sum())


def noise_std(differences: np.ndarray) -> np.ndarray:
    """Standard deviation (channels,) of signals about parabolas fitted to nine samples at a time.

    The median is robust against jolts. White noise keeps its standard deviation; noise that is correlated over a few
    rows loses less of it than in differences.

    Args:
        differences: (windows, rows, channels), NaN where there is no sample.
    """
    found = np.full(differences.shape[2], np.nan)
    for c in range(differences.shape[2]):
        left = [_beside_parabolas(signal[np.isfinite(signal)]) for signal in differences[:, :, c]]
        if any(len(part) for part in left):
            found[c] = np.median(np.abs(np.concatenate(left))) / 0.6745
    return found


def _beside_parabolas(signal: np.ndarray) -> np.ndarray:
    """Residuals of nine-sample parabolas, scaled so that white noise keeps its size; empty for shorter signals."""
    if len(signal) < _SPAN:
        return np.zeros(0)
    from scipy.signal import savgol_coeffs, savgol_filter  # imported here: it takes two seconds

    middle = savgol_coeffs(_SPAN, 2)[_SPAN // 2]
    inside = slice(_SPAN // 2, len(signal) - _SPAN // 2)
    return ((signal - savgol_filter(signal, _SPAN, 2)) / np.sqrt(1.0 - middle))[inside]


def noise_floor(channels: Channels, recordings: Sequence[Recording]) -> float:
    """The `accuracy.nrmse` that noise alone gives a perfect simulator; 0 without recordings."""
    shares = []
    for recording in recordings:
        table, span = channels.recorded(recording), channel_ranges(channels, recording)
        shares += [
            noise_std_of(recording.time, table[:, c]) / span[c] for c in range(table.shape[1]) if np.isfinite(span[c])
        ]
    found = np.array([s for s in shares if np.isfinite(s)])
    return float(np.sqrt(np.mean(found**2))) if found.size else 0.0


def median(values: np.ndarray) -> float:
    """Median of the finite values (n,); NaN if there is none."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else float("nan")
