"""Comparisons in which everything that a fit has free counts as fitted, and what they tell of the robot's own step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.slack import slack_of
from estexp_jax.discovery.slopes import Fit, jacobian

_LACKING = (1.0, 0.9, 0.8, 0.0)
"""Shares of the coarse step's error that a robot may lack: all of it, or it was simulated itself, at a tenth, a fifth
or the whole of that step."""
_CLEARLY = 0.75
"""A share other than 1 must bring the squared error under this part of what it is with 1."""


def slackened(problem: Problem, base: Fit, windows: np.ndarray, cost: float) -> Problem:
    """The comparison on some windows in which everything that a fit has free counts as fitted.

    Derivatives hold for small errors of the model's values, which a prior keeps small; the larger the mismatch that is
    still to be explained, the stronger it must be.

    Args:
        problem: the comparison.
        base: the fit.
        windows: indices of the windows.
        cost: of the best explanation so far, 1 for noise.
    """
    free, price = base.hypothesis.free, problem.price_of(windows) * max(1.0, cost)
    _, derivative = jacobian(problem, base, windows)
    claimed = np.array([np.isinf(f.spread) for f in free], dtype=bool)
    spread = np.array([(f.size or 1.0) if own else f.spread for f, own in zip(free, claimed, strict=True)])
    offset = np.where(claimed, 0.0, base.vector - base.hypothesis.start())
    return replace(problem, slack=slack_of(derivative, price / spread**2, offset))


def about(problem: Problem, base: Fit) -> Problem:
    """`Problem.about` a fit, with the share of the step's error that the robot lacks.

    A robot does not step, but one that was simulated did, perhaps as coarsely as its nominal simulator. Values fitted
    under one share fit that share best; so the shares are compared with all values fitted anew.
    """
    there = problem.about(base.member)
    own = float(np.sum(there.residuals([base.member], there.fitted).astype(float) ** 2))
    free = slackened(there, base, there.fitted, own)
    costs = {
        share: float(np.sum(replace(free, lacking=share).residuals([base.member], there.fitted).astype(float) ** 2))
        for share in _LACKING
    }
    best = min(costs, key=lambda share: costs[share])
    return replace(there, lacking=best if costs[best] < _CLEARLY * costs[1.0] else 1.0)
