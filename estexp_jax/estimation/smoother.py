"""Positions and speeds of a motion from noisy samples, with their covariance.

A Kalman filter and a Rauch-Tung-Striebel smoother for an acceleration that is a random walk. The spectral density of
the jerk is chosen for each motion by the likelihood of its own samples, so a slow arm is smoothed over many rows and a
jolting servo over few. Uneven clocks and gaps are handled by the model.

Sources: Rauch, Tung and Striebel, AIAA Journal 3 (1965); Saerkkae, Bayesian Filtering and Smoothing (2013), chapters 4,
8 and 12.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.ndimage import uniform_filter1d

_JERK_DENSITIES = 10.0 ** np.arange(-10.0, 6.5, 0.75)
"""Candidates for the spectral density of the jerk, in noise variances over row periods to the fifth."""
_LOCAL_ROWS = 4
"""The density is chosen by the likelihood of so many rows to either side ..."""
_GLOBAL_WEIGHT = 4.0
"""... and by the mean likelihood of the whole motion, which counts as so many rows."""
_REGULARISATION = 1e-9
"""Share added to variances before inversion: a motion sampled once leaves the covariance nearly singular."""
_LEAST_NOISE = 1e-6
"""Least noise, as a share of a motion's range: samples of a simulation have none."""


@final
@dataclass(frozen=True, eq=False)
class SmoothedTrack:
    """Estimated motion of n coordinates at each row.

    Attributes:
        value, slope: (rows, n), in the samples' unit and per second.
        covariance: (rows, n, 2, 2) of value and slope.
    """

    value: np.ndarray
    slope: np.ndarray
    covariance: np.ndarray


def smooth(
    time: np.ndarray, samples: np.ndarray, noise: np.ndarray, measured_slopes: np.ndarray, slope_noise: np.ndarray
) -> SmoothedTrack:
    """Smooth coordinates that were sampled with noise, and perhaps their derivatives too.

    Args:
        time: (rows,) s, increasing.
        samples: (rows, n), NaN where there is none; each column contains at least one.
        noise: (n,) their standard deviations.
        measured_slopes: (rows, n) derivatives, per second, NaN where there is none.
        slope_noise: (n,) their standard deviations.
    """
    period = float(np.median(np.diff(time)))
    intervals = np.diff(time) / period
    span = np.maximum(np.nanmax(samples, axis=0) - np.nanmin(samples, axis=0), 1e-12)
    unit = np.maximum(noise, _LEAST_NOISE * span)
    first = np.array([c[np.isfinite(c)][0] for c in samples.T])
    measured = np.stack([(samples - first) / unit, measured_slopes * period / unit], axis=2)
    speed = np.maximum(np.nan_to_num(slope_noise, nan=1.0) * period / unit, 1e-6)
    known = np.stack([np.ones_like(unit), speed**2], axis=1)
    wide = np.stack([(span / unit) ** 2 + 10.0, (span / unit) ** 2 + 10.0, (span / unit) ** 2 + 10.0], axis=1)
    jerk = _jerk_density(intervals, measured, known, wide)
    mean, cov = _backward(intervals, _filtered(intervals, measured, known, wide, jerk), jerk)
    scale = np.array([1.0, 1.0 / period])
    covariance = cov[..., :2, :2] * (unit**2)[:, None, None] * (scale[:, None] * scale[None, :])
    return SmoothedTrack(first + unit * mean[..., 0], unit * mean[..., 1] / period, covariance)


def _jerk_density(intervals: np.ndarray, measured: np.ndarray, known: np.ndarray, wide: np.ndarray) -> np.ndarray:
    """The likeliest jerk density (rows, n) about each row; the whole motion's likelihood counts a little everywhere."""
    steady = np.broadcast_to(_JERK_DENSITIES, (len(measured), measured.shape[1], len(_JERK_DENSITIES)))
    trial = _filtered(intervals, measured[:, :, None], known[:, None], wide[:, None], steady).likelihood
    near = uniform_filter1d(trial, 2 * _LOCAL_ROWS + 1, axis=0, mode="nearest") * (2 * _LOCAL_ROWS + 1)
    return _JERK_DENSITIES[np.argmax(near + _GLOBAL_WEIGHT * trial.mean(axis=0), axis=2)]


@dataclass(frozen=True, eq=False)
class _Filtered:
    """Means (rows, ..., 3) and covariances (rows, ..., 3, 3) after each row; rows' log-likelihoods (rows, ...)."""

    mean: np.ndarray
    covariance: np.ndarray
    likelihood: np.ndarray


def _filtered(
    intervals: np.ndarray, measured: np.ndarray, known: np.ndarray, wide: np.ndarray, jerk: np.ndarray
) -> _Filtered:
    """The filter, for any axes `...` of motions and candidates.

    Args:
        intervals: (rows - 1,) time between rows, in periods.
        measured: (rows, ..., 2) value and slope, NaN where there is none.
        known: (..., 2) their variances.
        wide: (..., 3) prior variances of value, slope and curvature.
        jerk: (rows, ...) spectral density of the jerk before each row.
    """
    shape = np.broadcast_shapes(measured.shape[1:-1], jerk.shape[1:])
    mean, cov = np.zeros((*shape, 3)), np.broadcast_to(wide[..., None] * np.eye(3), (*shape, 3, 3)).copy()
    means, covs = np.empty((len(measured), *shape, 3)), np.empty((len(measured), *shape, 3, 3))
    likelihood = np.zeros((len(measured), *shape))
    for row in range(len(measured)):
        if row:
            transition, process_noise = _motion(intervals[row - 1])
            mean = mean @ transition.T
            cov = transition @ cov @ transition.T + jerk[row, ..., None, None] * process_noise
        for k in range(2):
            mean, cov, gained = _updated(mean, cov, measured[row, ..., k], known[..., k], k)
            likelihood[row] += gained
        means[row], covs[row] = mean, cov
    return _Filtered(means, covs, likelihood)


def _updated(
    mean: np.ndarray, cov: np.ndarray, measured: np.ndarray, variance: np.ndarray, k: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray | float]:
    """Mean and covariance after a measurement of the state's coordinate `k`, and its log-likelihood."""
    present = np.isfinite(measured)
    if not present.any():
        return mean, cov, 0.0
    expected = cov[..., k, k] + variance
    innovation = np.where(present, measured, 0.0) - mean[..., k]
    weight = np.where(present, 1.0 / expected, 0.0)
    column = cov[..., :, k] * weight[..., None]
    gained = np.where(present, -0.5 * (innovation**2 / expected + np.log(expected)), 0.0)
    return (
        mean + column * innovation[..., None],
        cov - column[..., :, None] * cov[..., None, k, :],
        gained,
    )


def _backward(intervals: np.ndarray, filtered: _Filtered, jerk: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Smoothed means and covariances, from the filtered ones."""
    means, covs = filtered.mean.copy(), filtered.covariance.copy()
    for row in range(len(means) - 2, -1, -1):
        transition, process_noise = _motion(intervals[row])
        cov = filtered.covariance[row]
        ahead = transition @ cov @ transition.T + jerk[row + 1, ..., None, None] * process_noise
        ahead = ahead * (1.0 + _REGULARISATION * np.eye(3))
        back = np.swapaxes(np.linalg.solve(ahead, transition @ cov), -1, -2)
        means[row] += (back @ (means[row + 1] - filtered.mean[row] @ transition.T)[..., None])[..., 0]
        covs[row] = cov + back @ (covs[row + 1] - ahead) @ np.swapaxes(back, -1, -2)
    return means, covs


def _motion(gap: float) -> tuple[np.ndarray, np.ndarray]:
    """Transition of value, slope and curvature over an interval, and the covariance that unit jerk density adds."""
    g = float(gap)
    transition = np.array([[1.0, g, g * g / 2.0], [0.0, 1.0, g], [0.0, 0.0, 1.0]])
    process_noise = np.array([[g**5 / 20, g**4 / 8, g**3 / 6], [g**4 / 8, g**3 / 3, g**2 / 2], [g**3 / 6, g**2 / 2, g]])
    return transition, process_noise
