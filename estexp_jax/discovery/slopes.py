"""Fits, their derivatives by finite differences, and the damped steps that these suggest.

Source: Nocedal and Wright, Numerical Optimization (2006), chapter 10.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.discovery.hypotheses import Free, Hypothesis
from estexp_jax.discovery.problem import Problem
from estexp_jax.physics.effects.registry import effect

_STEP = 0.01
"""Finite-difference step, as a share of a parameter's present size ..."""
_LEAST_STEP = 1e-3
"""... and at least this share of its largest, ..."""
_LARGEST_STEP = 0.05
"""... but of what is always positive, at most this share: some of these span orders of magnitude."""
_FACTOR = 0.03
"""A common factor that is nearer to 1 is let be."""
DAMPINGS = (1e-7, 1e-4, 1e-2, 1.0)
_STRETCHED = 0.8
"""Share of its bound from which on a value of the model is farther off than wrong values should be."""
_UNFELT = 1e-8
"""Of the squared residuals, what a parameter's whole range must change for the slope to be more than rounding."""
_SMALL = 0.7
"""Steps up to this share of a value are taken by factors."""
_MOST_MEMBERS = 4096
"""Derivatives are taken by so many windows of simulations at once, to bound memory."""


@final
@dataclass(frozen=True, eq=False)
class Fit:
    """A hypothesis with its best parameters on some windows.

    Attributes:
        hypothesis: what is claimed.
        vector: (n_free,).
        cost: sum of squared residuals, 1 for noise, with the price of unusual values of the model.
    """

    hypothesis: Hypothesis
    vector: np.ndarray
    cost: float

    @property
    def member(self) -> tuple[Hypothesis, np.ndarray]:
        """As `Problem` takes it."""
        return self.hypothesis, self.vector


def stretched(fitted: Fit) -> list[Free]:
    """Values of the model that a fit bends farther than wrong values should be off."""
    ends = zip(fitted.hypothesis.free, fitted.vector, strict=True)
    return [f for f, value in ends if np.isfinite(f.spread) and abs(value) >= _STRETCHED * f.high]


def unbent(fitted: Fit) -> Fit:
    """What a fit claims, with the model's own values as they were."""
    ends = zip(fitted.hypothesis.free, fitted.vector, strict=True)
    return Fit(fitted.hypothesis, np.array([f.neutral if np.isfinite(f.spread) else v for f, v in ends]), np.inf)


def prior_cost(hypothesis: Hypothesis, vector: np.ndarray, price: float) -> float:
    """What values of the model that are off cost."""
    return price * sum(((v - f.neutral) / f.spread) ** 2 for f, v in zip(hypothesis.free, vector, strict=True))


def movable(hypothesis: Hypothesis) -> np.ndarray:
    """Which parameters (n_free,) are amounts."""
    return np.array([not f.chosen for f in hypothesis.free], dtype=bool)


def unfelt(fitted: Fit, changed: np.ndarray) -> np.ndarray:
    """Which parameters (n_free,) change nothing, of what each, by its slope, does to the squared residuals in all."""
    return changed < _UNFELT * max(1.0, fitted.cost)


def jacobian(problem: Problem, fitted: Fit, windows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residuals (windows, samples) and their derivatives (windows, samples, n_free) at a fit, by finite differences.

    Only amounts are derived by; the derivatives by others are zero.
    """
    [found] = jacobians(problem, [fitted], windows, [movable(fitted.hypothesis)])
    return found


def jacobians(
    problem: Problem, fits: Sequence[Fit], windows: np.ndarray, moving: Sequence[np.ndarray]
) -> Generator[tuple[np.ndarray, np.ndarray], None, None]:
    """`jacobian` of each fit, as many in one replay as memory allows: one alone would not fill it."""
    shifted = [_shifted(f, m) for f, m in zip(fits, moving, strict=True)]
    most = max(1, _MOST_MEMBERS // len(windows))
    groups = np.cumsum([len(vectors) for vectors, _ in shifted]) // most
    for group in np.unique(groups):
        chosen = np.flatnonzero(groups == group).tolist()
        members = [(fits[i].hypothesis, v) for i in chosen for v in shifted[i][0]]
        residuals = problem.residuals(members, windows)
        first = 0
        for i in chosen:
            vectors, steps = shifted[i]
            yield _differences(residuals[first : first + len(vectors)], steps)
            first += len(vectors)


def _shifted(fitted: Fit, moving: np.ndarray) -> tuple[list[np.ndarray], np.ndarray]:
    """A fit's vector and, for each parameter that moves, one with a step in it; the steps (n_free,), 0 for others."""
    steps = np.where(moving, _steps(fitted.hypothesis, fitted.vector), 0.0)
    return [fitted.vector, *(fitted.vector + row for row in np.diag(steps)[moving])], steps


def _differences(residuals: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Residuals and derivatives, of residuals (1 + moving parameters, windows, samples)."""
    flat = residuals.astype(np.float64)
    derivative = np.zeros((*flat.shape[1:], len(steps)))
    columns = np.flatnonzero(steps)
    derivative[..., columns] = np.moveaxis((flat[1:] - flat[0]) / steps[columns, None, None], 0, -1)
    return flat[0], derivative


def normal_equations(
    fitted: Fit, price: float, residual: np.ndarray, derivative: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Gradient (n_free,) and Gauss-Newton matrix (n_free, n_free) of half the cost."""
    j = derivative.reshape(int(np.prod(derivative.shape[:-1])), derivative.shape[-1])
    curvature = price / np.array([f.spread for f in fitted.hypothesis.free]) ** 2
    offset = fitted.vector - fitted.hypothesis.start()
    return j.T @ residual.reshape(-1) + curvature * offset, j.T @ j + np.diag(curvature)


def _steps(hypothesis: Hypothesis, vector: np.ndarray) -> np.ndarray:
    """Finite-difference steps (n_free,), away from a bound that is near."""
    found = []
    for f, v in zip(hypothesis.free, vector, strict=True):
        step = max(_STEP * abs(v - f.origin), _LEAST_STEP * f.size)
        step = min(step, _LARGEST_STEP * max(v, f.low)) if f.low > 0.0 else step
        found.append(-step if v + step > f.high else step)
    return np.array(found)


def candidates(fitted: Fit, moving: np.ndarray, gradient: np.ndarray, matrix: np.ndarray) -> list[np.ndarray]:
    """Damped steps of the moving parameters, within bounds.

    Those that a bound already holds back stay there, and so do those that change nothing.
    """
    free, vector = fitted.hypothesis.free, fitted.vector
    low, high = np.array([f.low for f in free]), np.array([f.high for f in free])
    size = np.array([f.size for f in free])
    held = (
        ~moving
        | unfelt(fitted, np.diag(matrix) * size**2)
        | ((vector <= low) & (gradient > 0))
        | ((vector >= high) & (gradient < 0))
    )
    scale = np.sqrt(np.maximum(np.diag(matrix), 1e-30))
    unit = np.where(held, 0.0, 1.0) / scale
    normal = matrix * unit[:, None] * unit[None, :]
    found = []
    for damping in DAMPINGS:
        regular = normal + np.diag(np.where(held, 1.0, damping + 1e-12))
        found.append(np.clip(_moved(fitted, -unit * np.linalg.solve(regular, unit * gradient)), low, high))
    return found


def rescaled(fitted: Fit) -> list[np.ndarray]:
    """The vector with all masses, motors, dampings and frictions by one factor, if values of the model are nearer then.

    Along that valley slopes by differences seem steep where it is flat, and no step follows it far.
    """
    free = fitted.hypothesis.free
    base, ordinary = np.array([f.present for f in free]), np.array([np.isfinite(f.spread) for f in free], dtype=bool)
    grows = (base > 0.0) | np.array([_is_force(f) for f in free], dtype=bool)
    sign = np.array([-1.0 if f.loss else 1.0 for f in free])
    total = base + sign * fitted.vector
    weight = np.where(ordinary & grows, 1.0 / np.array([f.spread for f in free]) ** 2, 0.0)
    if not weight.any():
        return []
    factor = float(np.sum(weight * base * total) / np.sum(weight * total**2))
    if abs(factor - 1.0) < _FACTOR:
        return []
    low, high = fitted.hypothesis.bounds()
    return [np.where(grows, np.clip(sign * (factor * total - base), low, high), fitted.vector)]


def _is_force(f: Free) -> bool:
    unit = next(p.unit for p in effect(f.effect).parameters if p.name == f.parameter)
    return unit.startswith(("N", "kg"))


def _moved(fitted: Fit, step: np.ndarray) -> np.ndarray:
    """The vector after a step, taken by factors where it is not too large for that.

    Masses, motors, dampings and frictions that all grow by one factor leave most motions as they are. Factors follow
    this valley where sums would leave it.
    """
    free, vector = fitted.hypothesis.free, fitted.vector
    sign = np.array([-1.0 if f.loss else 1.0 for f in free])
    base = np.array([f.present for f in free])
    total = base + sign * vector
    share = sign * step / np.where(total > 0.0, total, np.inf)
    by_factor = (total > 0.0) & (np.abs(share) < _SMALL)
    return np.where(by_factor, sign * (total * np.exp(np.clip(share, -1.0, 1.0)) - base), vector + step)
