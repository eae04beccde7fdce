"""Explanations judged on windows that they were not fitted to.

A hypothesis that is fitted to all windows is close to its fit to a part of them: one Gauss-Newton step away, with the
derivatives that are known. So no hypothesis is fitted anew for each part; what the step leads to is simulated.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import Explanation, Fold
from estexp_jax.discovery.slopes import DAMPINGS, Fit, candidates, jacobians, movable, normal_equations, prior_cost

_THROWN, _SINGLE = 9.0, 0.1
"""A window's squared error may grow by this factor when it is held out; more is bounded, if so few windows do."""
_AS_WELL = 0.005
"""A step whose squared error is larger by no more than this share fits as well."""
_BEST = 8
"""So many explanations, the best ones, are worth the derivatives when they are judged again."""


def cross_validated(problem: Problem, fits: Sequence[Fit], folds: Sequence[Fold]) -> list[Explanation]:
    """Each hypothesis fitted anew without each fold's held-out windows, and judged on them.

    Args:
        problem: the comparison.
        fits: to all windows of the folds.
        folds: windows to fit, windows held out; each is held out once.
    """
    windows = np.sort(np.concatenate([held for _, held in folds]))
    prices = problem.prices([f.member for f in fits])
    samples, moving = problem.recorded.samples(windows), [movable(f.hypothesis) for f in fits]
    slopes = list(jacobians(problem, fits, windows, moving))
    left = [np.sum(residual**2, axis=1) for residual, _ in slopes]
    judged = np.zeros((len(fits), len(windows)))
    shares = np.zeros(len(windows))
    for part, held in folds:
        inside, outside = np.isin(windows, part), np.isin(windows, held)
        shares[outside] = samples.sum() / samples[outside].sum() / len(folds)
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
            judged[i, outside] = own[shortest(costs), outside]
    order = np.concatenate([np.flatnonzero(np.isin(windows, held)) for _, held in folds])
    unusual = [prior_cost(f.hypothesis, f.vector, price) for f, price in zip(fits, prices, strict=True)]
    return [
        Explanation(f, (bounded(own, fitted) * shares)[order], cost)
        for f, own, fitted, cost in zip(fits, judged, left, unusual, strict=True)
    ]


def shortest(costs: Sequence[float]) -> int:
    """The shortest step that fits as well as any does.

    Where windows hardly tell an amount, the longest step fits them a few thousandths better, and may throw the windows
    that are held out far off.

    Args:
        costs: (steps,) from the longest step to the shortest.
    """
    return int(np.flatnonzero(np.asarray(costs) <= (1 + _AS_WELL) * min(costs))[-1])


def bounded(held_out: np.ndarray, fitted: np.ndarray) -> np.ndarray:
    """Squared errors of held-out windows without those of single windows that the step throws far off.

    Where a motion hangs on a hair, such as whether a stop is touched, parameters that moved within their doubt end
    elsewhere. That tells nothing of a hypothesis; what predicts many windows badly is told by them.

    Args:
        held_out: (windows,) sums of squared residuals.
        fitted: (windows,) the same, of the fit to all windows.
    """
    n = len(held_out)
    most = _THROWN * np.maximum(fitted, 1.0 / n)
    far = held_out > most
    return np.where(far, most, held_out) if far.sum() <= _SINGLE * n else held_out


def judged_again(problem: Problem, found: Sequence[Explanation], folds: Sequence[Fold]) -> list[Explanation]:
    """Explanations, in their order, judged by one comparison: the best anew, the others as they stand.

    By comparisons about different fits, with other doubts about steps and starts, they could not be compared.
    """
    if not found:
        return []
    fits = [e.fitted for e in found]
    there = problem.corrected([f.member for f in fits])
    best = sorted(range(len(found)), key=lambda i: found[i].error)[:_BEST]
    again = as_fitted(there, fits, folds)
    for i, e in zip(best, cross_validated(there, [fits[i] for i in best], folds), strict=True):
        again[i] = e
    return again


def as_fitted(problem: Problem, fits: Sequence[Fit], folds: Sequence[Fold]) -> list[Explanation]:
    """Hypotheses as they stand, judged on the same windows."""
    if not fits:
        return []
    members = [f.member for f in fits]
    squares = [np.sum(np.square(problem.residuals(members, held), dtype=np.float64), axis=2) for _, held in folds]
    each = np.concatenate(squares, axis=1) / len(folds)
    unusual = [prior_cost(f.hypothesis, f.vector, p) for f, p in zip(fits, problem.prices(members), strict=True)]
    return [Explanation(f, own, cost) for f, own, cost in zip(fits, each, unusual, strict=True)]
