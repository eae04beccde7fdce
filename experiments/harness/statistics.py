"""The few statistics that the experiments report."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from scipy import stats


def interval(values: Sequence[float], level: float = 0.9, draws: int = 2000) -> tuple[float, float]:
    """Bootstrap interval of the mean; the seed is fixed, so that figures are drawn alike."""
    x = np.asarray(values, float)
    means = np.random.default_rng(0).choice(x, (draws, len(x))).mean(axis=1)
    low, high = np.quantile(means, [(1 - level) / 2, (1 + level) / 2])
    return float(low), float(high)


def signed_rank(a: Sequence[float], b: Sequence[float], alternative: str = "greater") -> float:
    """p of the Wilcoxon signed-rank test that a exceeds b, pair by pair; 1 where nothing differs."""
    difference = np.asarray(a, float) - np.asarray(b, float)
    if not np.any(difference):
        return 1.0
    return float(stats.wilcoxon(difference, alternative=alternative).pvalue)  # pyright: ignore


def holm(p: Sequence[float]) -> list[float]:
    """p values corrected for their number (Holm 1979): p_(i) (m - i), made monotone, at most 1."""
    values = np.asarray(p, float)
    order = np.argsort(values)
    factors = len(values) - np.arange(len(values))
    corrected = np.minimum(np.maximum.accumulate(values[order] * factors), 1.0)
    result = np.empty_like(values)
    result[order] = corrected
    return result.tolist()


def share(successes: int, n: int, level: float = 0.9) -> tuple[float, float]:
    """Wilson interval of a share."""
    if n == 0:
        return 0.0, 1.0
    found = stats.binomtest(successes, n).proportion_ci(level, "wilson")
    return float(found.low), float(found.high)
