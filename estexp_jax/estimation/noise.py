"""How large a reading's noise is, from the recording alone."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy.signal import savgol_coeffs, savgol_filter

from estexp_jax.estimation.channels import Channels, channel_ranges
from estexp_jax.physics.reading_noise import noise_std_of
from estexp_jax.physics.recording import Recording

_NINE = 9


def correlation_rows(residuals: np.ndarray) -> float:
    """For how many rows residuals go on as they are: so many count as one independent sample; 1 for white noise.

    The sum of the autocorrelation over lags, up to where it first falls under a twentieth.

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
    """Standard deviation (channels,) of what is left of signals beside parabolas through nine samples at a time.

    Median size counts, so that jolts do not. White noise keeps its deviation; noise that lasts for a few rows keeps
    more of it than in differences.

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
    """What nine-sample parabolas leave, enlarged by what they take of white noise; nothing of a shorter signal."""
    if len(signal) < _NINE:
        return np.zeros(0)
    middle = savgol_coeffs(_NINE, 2)[_NINE // 2]
    inside = slice(_NINE // 2, len(signal) - _NINE // 2)
    return ((signal - savgol_filter(signal, _NINE, 2)) / np.sqrt(1.0 - middle))[inside]


def noise_floor(channels: Channels, recordings: Sequence[Recording]) -> float:
    """The error that noise alone gives a perfect simulator, in the unit of `accuracy.nrmse`; 0 for no recording."""
    shares = []
    for recording in recordings:
        table, span = channels.recorded(recording), channel_ranges(channels, recording)
        shares += [
            noise_std_of(recording.time, table[:, c]) / span[c] for c in range(table.shape[1]) if np.isfinite(span[c])
        ]
    found = np.array([s for s in shares if np.isfinite(s)])
    return float(np.sqrt(np.mean(found**2))) if found.size else 0.0


def median(values: np.ndarray) -> float:
    """Median of the values (n,) that are known; NaN where none is."""
    known = values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else float("nan")
