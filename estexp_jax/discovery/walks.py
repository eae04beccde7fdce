"""A fit on its way: the steps that its slopes suggest, and what each window says of cost and slopes.

Sources: Madsen, Nielsen and Tingleff, Methods for Non-Linear Least Squares Problems (2004), section 3.5 (slopes that a
step mends).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estexp_jax.discovery.slopes import Fit, candidates, normal_equations, prior_cost, rescaled

CONVERGED = 1e-3
"""Relative fall of the cost under which a fit rests."""
_LEAPS = (0.4, 2.5)
"""Factors that are tried in first looks at motions that soon part for good from those of a robot that differs a little,
as on legs: a single window in which they do makes slopes meaningless."""
_STEEP, _MOST = 3.0, 4.0
"""Of such motions: times as steep as the median window's slopes from which on a window's slopes are heeded less, and
times the median window's squared error that a window counts at most."""


@dataclass
class Walk:
    """A fit on its way: where it is, and what is known of the slopes there.

    Attributes:
        at: where.
        moving: (n_free,) which parameters move.
        residual, derivative: (windows, samples), (windows, samples, n_free).
        price: of unusual values.
        goes_on: whether another step with these derivatives may pay.
        rests: whether no step would.
        leaps: whether steps are tried that no slope tells of.
        rescales: whether it is tried to change all masses, motors and frictions by one factor.
        weights: (windows,) how far to heed what each window's slopes say.
    """

    at: Fit
    moving: np.ndarray
    residual: np.ndarray
    derivative: np.ndarray
    price: float
    goes_on: bool = True
    rests: bool = False
    leaps: bool = False
    rescales: bool = False
    weights: np.ndarray | None = None

    def candidates(self) -> list[np.ndarray]:
        """Where a step may lead."""
        weights = 1.0 if self.weights is None else self.weights[:, None]
        residual, derivative = weights * self.residual, np.expand_dims(weights, -1) * self.derivative
        slopes = normal_equations(self.at, self.price, residual, derivative)
        steps = candidates(self.at, self.moving, *slopes)
        return [*steps, *(self._leaps() if self.leaps else ()), *(rescaled(self.at) if self.rescales else ())]

    def _leaps(self) -> list[np.ndarray]:
        """Less and more of what the first moving parameter says, whatever the slopes are."""
        first = int(np.argmax(self.moving))
        f, found = self.at.hypothesis.free[first], []
        for factor in _LEAPS:
            leapt = self.at.vector.copy()
            leapt[first] = np.clip(f.origin + factor * (leapt[first] - f.origin), f.low, f.high)
            found.append(leapt)
        return found

    def step_to(self, vectors: Sequence[np.ndarray], residuals: np.ndarray) -> None:
        """Go to the best of some candidates, whose residuals (candidates, windows, samples) are known, if it is better.

        Derivatives along the step are mended by what it showed.
        """
        hypothesis, costs = self.at.hypothesis, data_costs(residuals, self.weights is not None)
        costs += [prior_cost(hypothesis, v, self.price) for v in vectors]
        best = int(np.argmin(costs))
        new = Fit(hypothesis, vectors[best], float(costs[best]))
        if new.cost >= self.at.cost:
            self.goes_on = False
            return
        step, shown = new.vector - self.at.vector, residuals[best].astype(np.float64)
        expected = self.residual + self.derivative @ step
        foreseen = self.at.cost - np.sum(expected**2) - prior_cost(hypothesis, new.vector, self.price)
        small = CONVERGED * self.at.cost
        self.rests = self.at.cost - new.cost < small and foreseen < 2.0 * small
        self.goes_on = self.at.cost - new.cost >= small
        weight = np.einsum("wsn,wsn->n", self.derivative, self.derivative) * step
        if weight @ step > 0.0:
            self.derivative += (shown - expected)[..., None] * (weight / (weight @ step))
        self.at, self.residual = new, shown


def data_costs(residuals: np.ndarray, parting: bool) -> np.ndarray:
    """Squared residuals (members,), of (members, windows, samples).

    Where motions soon part a window counts at most as several usual ones: one in which a foot slips or not, as chance
    has it, must not hide what the others say.
    """
    squares = np.sum(np.square(residuals, dtype=np.float64), axis=2)
    if parting:
        squares *= counting(squares)
    return squares.sum(axis=1)


def counting(squares: np.ndarray) -> np.ndarray:
    """Factors on squared errors (..., windows) that let each window count as much as it may at most."""
    most = _MOST * np.median(squares, axis=-1, keepdims=True)
    return np.minimum(1.0, most / np.maximum(squares, 1e-30))


def heeded(fitted: Fit, derivative: np.ndarray) -> np.ndarray:
    """Weights (windows,) of slopes: less than 1 in windows whose slopes are many times as steep as is usual.

    There the robot parts for good from one that differs by a finite-difference step.
    """
    sizes = np.array([f.spread if np.isfinite(f.spread) else 0.1 * f.size for f in fitted.hypothesis.free])
    steep = np.sqrt(np.einsum("wsn,n->w", derivative**2, sizes**2))
    usual = float(np.median(steep))
    return np.minimum(1.0, _STEEP * usual / np.maximum(steep, 1e-30)) if usual > 0.0 else np.ones(len(steep))
