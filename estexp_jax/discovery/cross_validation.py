"""Explanations judged on windows that they were not fitted to.

A hypothesis that is fitted to all windows is close to its fit to a part of them: one Gauss-Newton step away, with the
derivatives that are known. So no hypothesis is fitted anew for each part; what the step leads to is simulated.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.discovery.fitting import DAMPINGS, Fit, candidates, jacobians, movable, normal_equations, prior_cost
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import Explanation, Fold


def cross_validated(problem: Problem, fits: Sequence[Fit], folds: Sequence[Fold]) -> list[Explanation]:
    """Each hypothesis fitted anew without each fold's held-out windows, and judged on them.

    Args:
        problem: the comparison.
        fits: to all windows of the folds.
        folds: windows to fit, windows held out; each is held out once.
    """
    windows = np.sort(np.concatenate([held for _, held in folds]))
    prices = problem.prices([f.member for f in fits])
    samples, moving = problem.samples(windows), [movable(f.hypothesis) for f in fits]
    slopes = list(jacobians(problem, fits, windows, moving))
    parts: list[list[np.ndarray]] = [[] for _ in fits]
    for part, held in folds:
        inside, outside = np.isin(windows, part), np.isin(windows, held)
        share = samples.sum() / samples[outside].sum() / len(folds)
        tried = [
            candidates(f, own, *normal_equations(f, price, residual[inside], derivative[inside]))
            for f, own, (residual, derivative), price in zip(fits, moving, slopes, prices, strict=True)
        ]
        members = [(f.hypothesis, vector) for f, vectors in zip(fits, tried, strict=True) for vector in vectors]
        squares = np.asarray(np.sum(problem.residuals(members, windows) ** 2, axis=2, dtype=np.float64))
        for i, (f, price) in enumerate(zip(fits, prices, strict=True)):
            own = squares[i * len(DAMPINGS) : (i + 1) * len(DAMPINGS)]
            costs = [
                square[inside].sum() + prior_cost(f.hypothesis, vector, price)
                for square, vector in zip(own, tried[i], strict=True)
            ]
            parts[i].append(own[int(np.argmin(costs)), outside] * share)
    return [Explanation(f, np.concatenate(part)) for f, part in zip(fits, parts, strict=True)]


def as_fitted(problem: Problem, fits: Sequence[Fit], folds: Sequence[Fold]) -> list[Explanation]:
    """Hypotheses as they stand, judged on the same windows."""
    if not fits:
        return []
    members = [f.member for f in fits]
    squares = [np.sum(np.square(problem.residuals(members, held), dtype=np.float64), axis=2) for _, held in folds]
    each = np.concatenate(squares, axis=1) / len(folds)
    return [Explanation(f, own) for f, own in zip(fits, each, strict=True)]
