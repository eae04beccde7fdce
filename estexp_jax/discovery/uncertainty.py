"""Intervals: how far parameters and gains may be from what was found."""

from __future__ import annotations

import numpy as np

from estexp_jax.discovery.fitting import Fit, jacobian
from estexp_jax.discovery.problem import Problem
from estexp_jax.inference.accuracy import gain

_NORMAL_90 = 1.645
_ENDS_90 = (5.0, 95.0)


def parameter_intervals(problem: Problem, fitted: Fit) -> np.ndarray:
    """90 % interval (n_free, 2) of each parameter, within its bounds.

    Residuals within a window are correlated, so windows, not samples, count as independent (the cluster-robust
    "sandwich" covariance); with fewer windows than parameters it is a lower limit of the uncertainty. Values of the
    model that the data do not settle stay near nominal, and may be off as much as such values usually are.

    Source: Liang and Zeger, Biometrika 73 (1986).
    """
    windows, [price] = problem.fitted, problem.prices([fitted.member])
    residual, derivative = jacobian(problem, fitted, windows)
    free = fitted.hypothesis.free
    scale = np.array([f.size for f in free])
    j = derivative.reshape(-1, len(free)) * scale
    bread = np.linalg.pinv(j.T @ j + np.diag(price * (scale / [f.spread for f in free]) ** 2), hermitian=True)
    scores = np.einsum("wsp,ws->wp", derivative * scale, residual)
    n = len(windows)
    pulled = np.diag((price * scale / [f.spread for f in free]) ** 2)
    covariance = bread @ (scores.T @ scores * (n / max(n - 1, 1)) + pulled) @ bread
    reach = _NORMAL_90 * np.sqrt(np.maximum(np.diag(covariance), 0.0)) * scale
    low, high = np.array([f.low for f in free]), np.array([f.high for f in free])
    return np.clip(np.stack([fitted.vector - reach, fitted.vector + reach], axis=1), low[:, None], high[:, None])


def gain_interval(nominal: np.ndarray, explained: np.ndarray, floor: float, seed: int, n: int = 2000) -> np.ndarray:
    """90 % interval (2,) of the gain, from resampled windows.

    Args:
        nominal: (windows,) each window's squared nrmse.
        explained: likewise.
        floor: noise floor, an nrmse.
        seed: of the resampling.
        n: number of resamples.
    """
    size = len(nominal)
    drawn = np.random.default_rng(seed).integers(0, size, size=(n, size))
    found = np.array([gain(np.sqrt(explained[d].mean()), np.sqrt(nominal[d].mean()), floor) for d in drawn])
    return np.percentile(found[np.isfinite(found)], _ENDS_90) if np.isfinite(found).any() else np.full(2, np.nan)
