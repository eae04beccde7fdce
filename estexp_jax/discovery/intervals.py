"""Intervals: how far parameters and gains may be from what was found."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.stats import t as student

from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.slopes import Fit, jacobian, movable, unfelt
from estexp_jax.discovery.walks import counting, heeded
from estexp_jax.estimation.accuracy import gain

_UPPER = 0.95
_STEP_DOUBT = 0.1
"""Share of what no steps at all would change that is in doubt."""
_ENDS_90 = (5.0, 95.0)


def parameter_intervals(problem: Problem, fitted: Fit) -> np.ndarray:
    """90 % interval (n_free, 2) of each parameter, within its bounds.

    Three things add up. Residuals within a window are correlated, so windows, not samples, count as independent: each
    is left out in turn (the jackknife, by one Gauss-Newton step; with few windows it is on the safe side, where the
    cluster-robust covariance is too small). Values of the model that the data do not settle stay near nominal, and may
    be off as much as such values usually are. And of the error of the step, which is reckoned out, a part is doubtful:
    it acts like a delay. Where motions hang on hairs, windows count as in the fit. What changes nothing may have
    any value within its bounds.

    Source: Liang and Zeger, Biometrika 73 (1986); Bell and McCaffrey, Survey Methodology 28 (2002).
    """
    windows, [price] = problem.fitted, problem.prices([fitted.member])
    residual, derivative = jacobian(problem, fitted, windows)
    coarser = replace(problem, lacking=problem.lacking - _STEP_DOUBT).residuals([fitted.member], windows)[0]
    if problem.hairs:
        counts = np.sqrt(counting(np.sum(residual**2, axis=1)))
        weights = (heeded(fitted, derivative) * counts)[:, None]
        residual, derivative, coarser = weights * residual, weights[..., None] * derivative, weights * coarser
    free = fitted.hypothesis.free
    scale, spread = np.array([f.size for f in free]), np.array([f.spread for f in free])
    n, slopes = len(windows), derivative * scale
    grams, ridge = np.einsum("wsp,wsq->wpq", slopes, slopes), np.diag(price * (scale / spread) ** 2)
    whole = grams.sum(axis=0) + ridge
    bread = np.linalg.pinv(whole, hermitian=True)
    scores = np.einsum("wsp,ws->wp", slopes, residual)
    left_out = [
        np.linalg.lstsq(np.eye(len(free)) - gram @ bread, s, rcond=None)[0]
        for gram, s in zip(grams, scores, strict=True)
    ]
    moved = np.stack(left_out) @ bread
    pulled = np.diag((price * scale / spread) ** 2)
    late = bread @ np.einsum("wsp,ws->p", slopes, coarser.astype(np.float64) - residual)
    variance = (n - 1) / n * np.sum(moved**2, axis=0) + np.diag(bread @ pulled @ bread) + late**2
    reach = float(student.ppf(_UPPER, max(n - 1, 1))) * np.sqrt(np.maximum(variance, 0.0)) * scale
    reach[unfelt(fitted, np.diag(whole)) & movable(fitted.hypothesis)] = np.inf
    low, high = np.array([f.low for f in free]), np.array([f.high for f in free])
    return np.clip(np.stack([fitted.vector - reach, fitted.vector + reach], axis=1), low[:, None], high[:, None])


def ratio_interval(a: np.ndarray, b: np.ndarray, seed: int, n: int = 2000) -> np.ndarray:
    """90 % interval (2,) of the ratio of the means of a and b (windows,), from resampled windows."""
    drawn = np.random.default_rng(seed).integers(0, len(a), size=(n, len(a)))
    return np.percentile(a[drawn].mean(axis=1) / np.maximum(b[drawn].mean(axis=1), 1e-300), _ENDS_90)


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
