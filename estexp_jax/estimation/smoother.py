"""Positions and speeds of a motion read from noisy samples, and how uncertain they are.

A Kalman filter runs forth and a Rauch-Tung-Striebel smoother back over the model that the acceleration drifts like a
random walk. How fast it drifts is chosen for each motion by the likelihood of its own samples, so a lazy arm is
smoothed over many rows and a jolting servo over few. Uneven clocks and gaps need no special care.

Sources: Rauch, Tung and Striebel, AIAA Journal 3 (1965); Saerkkae, Bayesian Filtering and Smoothing (2013), chapters 4,
8 and 12.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np
from scipy.ndimage import uniform_filter1d

_DRIFTS = 10.0 ** np.arange(-10.0, 6.5, 0.75)
"""Candidates for the density of the jerk, in noise variances over row periods to the fifth."""
_NEAR = 4
"""The likelihood of so many rows to either side chooses ..."""
_WHOLE = 4.0
"""... together with the whole motion's, which counts as so many rows."""
_REGULAR = 1e-9
"""Share added to variances that are inverted: a motion sampled once has hardly any information in some directions."""
_LEAST_NOISE = 1e-6
"""Of a motion's range: samples of a simulation have none."""


@final
@dataclass(frozen=True, eq=False)
class SmoothedTrack:
    """A motion as its samples show it, for n coordinates at each row.

    Attributes:
        value, slope: (rows, n), in the samples' unit and per second.
        covariance: (rows, n, 2, 2) of value and slope.
    """

    value: np.ndarray
    slope: np.ndarray
    covariance: np.ndarray


def smooth(
    time: np.ndarray, samples: np.ndarray, noise: np.ndarray, slopes: np.ndarray, slope_noise: np.ndarray
) -> SmoothedTrack:
    """The track of coordinates that were sampled with noise, and whose slopes perhaps were too.

    Args:
        time: (rows,) s, increasing.
        samples: (rows, n), NaN where there is none; each column holds at least one.
        noise: (n,) their standard deviations.
        slopes: (rows, n), NaN where there is none.
        slope_noise: (n,) their standard deviations.
    """
    period = float(np.median(np.diff(time)))
    gaps = np.diff(time) / period
    span = np.maximum(np.nanmax(samples, axis=0) - np.nanmin(samples, axis=0), 1e-12)
    unit = np.maximum(noise, _LEAST_NOISE * span)
    first = np.array([c[np.isfinite(c)][0] for c in samples.T])
    seen = np.stack([(samples - first) / unit, slopes * period / unit], axis=2)
    speed = np.maximum(np.nan_to_num(slope_noise, nan=1.0) * period / unit, 1e-6)
    known = np.stack([np.ones_like(unit), speed**2], axis=1)
    wide = np.stack([(span / unit) ** 2 + 10.0, (span / unit) ** 2 + 10.0, (span / unit) ** 2 + 10.0], axis=1)
    drift = _drift(gaps, seen, known, wide)
    mean, cov = _backward(gaps, _filtered(gaps, seen, known, wide, drift), drift)
    scale = np.array([1.0, 1.0 / period])
    covariance = cov[..., :2, :2] * (unit**2)[:, None, None] * (scale[:, None] * scale[None, :])
    return SmoothedTrack(first + unit * mean[..., 0], unit * mean[..., 1] / period, covariance)


def _drift(gaps: np.ndarray, seen: np.ndarray, known: np.ndarray, wide: np.ndarray) -> np.ndarray:
    """The likeliest density of the jerk (rows, n), around each row; the whole motion counts a little everywhere."""
    steady = np.broadcast_to(_DRIFTS, (len(seen), seen.shape[1], len(_DRIFTS)))
    trial = _filtered(gaps, seen[:, :, None], known[:, None], wide[:, None], steady).likelihood
    near = uniform_filter1d(trial, 2 * _NEAR + 1, axis=0, mode="nearest") * (2 * _NEAR + 1)
    return _DRIFTS[np.argmax(near + _WHOLE * trial.mean(axis=0), axis=2)]


@dataclass(frozen=True, eq=False)
class _Filtered:
    """Means (rows, ..., 3), covariances (rows, ..., 3, 3) after each row; each row's log-likelihood (rows, ...)."""

    mean: np.ndarray
    covariance: np.ndarray
    likelihood: np.ndarray


def _filtered(gaps: np.ndarray, seen: np.ndarray, known: np.ndarray, wide: np.ndarray, drift: np.ndarray) -> _Filtered:
    """The filter, for any leading axes `...` of motions and candidates.

    Args:
        gaps: (rows - 1,) time between rows.
        seen: (rows, ..., 2) measured value and slope, NaN where there is none.
        known: (..., 2) their variances.
        wide: (..., 3) variances before the first row.
        drift: (rows, ...) density of the jerk before each row.
    """
    shape = np.broadcast_shapes(seen.shape[1:-1], drift.shape[1:])
    mean, cov = np.zeros((*shape, 3)), np.broadcast_to(wide[..., None] * np.eye(3), (*shape, 3, 3)).copy()
    means, covs = np.empty((len(seen), *shape, 3)), np.empty((len(seen), *shape, 3, 3))
    likelihood = np.zeros((len(seen), *shape))
    for row in range(len(seen)):
        if row:
            move, spread = _motion(gaps[row - 1])
            mean = mean @ move.T
            cov = move @ cov @ move.T + drift[row, ..., None, None] * spread
        for k in range(2):
            mean, cov, gained = _updated(mean, cov, seen[row, ..., k], known[..., k], k)
            likelihood[row] += gained
        means[row], covs[row] = mean, cov
    return _Filtered(means, covs, likelihood)


def _updated(
    mean: np.ndarray, cov: np.ndarray, seen: np.ndarray, variance: np.ndarray, k: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray | float]:
    """Mean and covariance once coordinate `k` of the state was measured, and the log-likelihood of that."""
    there = np.isfinite(seen)
    if not there.any():
        return mean, cov, 0.0
    expected = cov[..., k, k] + variance
    surprise = np.where(there, seen, 0.0) - mean[..., k]
    weight = np.where(there, 1.0 / expected, 0.0)
    pull = cov[..., :, k] * weight[..., None]
    gained = np.where(there, -0.5 * (surprise**2 / expected + np.log(expected)), 0.0)
    return mean + pull * surprise[..., None], cov - pull[..., :, None] * cov[..., None, k, :], gained


def _backward(gaps: np.ndarray, filtered: _Filtered, drift: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Means and covariances given all rows, from those given the rows so far."""
    means, covs = filtered.mean.copy(), filtered.covariance.copy()
    for row in range(len(means) - 2, -1, -1):
        move, spread = _motion(gaps[row])
        cov = filtered.covariance[row]
        ahead = move @ cov @ move.T + drift[row + 1, ..., None, None] * spread
        ahead = ahead * (1.0 + _REGULAR * np.eye(3))
        back = np.swapaxes(np.linalg.solve(ahead, move @ cov), -1, -2)
        means[row] += (back @ (means[row + 1] - filtered.mean[row] @ move.T)[..., None])[..., 0]
        covs[row] = cov + back @ (covs[row + 1] - ahead) @ np.swapaxes(back, -1, -2)
    return means, covs


def _motion(gap: float) -> tuple[np.ndarray, np.ndarray]:
    """How value, slope and curvature move on over a gap, and the covariance that unit jerk density adds."""
    g = float(gap)
    move = np.array([[1.0, g, g * g / 2.0], [0.0, 1.0, g], [0.0, 0.0, 1.0]])
    spread = np.array([[g**5 / 20, g**4 / 8, g**3 / 6], [g**4 / 8, g**3 / 3, g**2 / 2], [g**3 / 6, g**2 / 2, g]])
    return move, spread
