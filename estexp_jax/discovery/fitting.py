"""Fitting many hypotheses at once: bounded Levenberg-Marquardt on finite differences, all of it in batched replays.

The damping is chosen each time among four candidates simulated together, which costs no extra round trip. Derivatives
by many values cost most; so some steps are taken with those of the last point, mended by what the step showed.

Sources: Nocedal and Wright, Numerical Optimization (2006), chapter 10; Madsen, Nielsen and Tingleff, Methods for
Non-Linear Least Squares Problems (2004), section 3.5 (the secant version).
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.slopes import Fit, candidates, jacobians, movable, normal_equations, prior_cost

_CONVERGED = 1e-3
"""Relative fall of the cost under which a fit rests."""
FAR, _ROUGHLY = 10.0, 1e-2
"""Deviations beyond which a fit leaves so much that a first one may rest at this relative fall of the cost."""
_STEPS_EACH = 4
"""Most steps with derivatives found once."""
_LEAPS = (0.4, 2.5)
"""Factors that are tried in first looks at motions that soon part for good from those of a robot that differs a little,
as on legs: a single window in which they do makes slopes meaningless."""
_STEEP, _MOST = 3.0, 4.0
"""Of such motions: times as steep as the median window's slopes from which on a window's slopes are heeded less, and
times the median window's squared error that a window counts at most."""


Task = tuple[Hypothesis, Sequence[np.ndarray]]


class Progress(NamedTuple):
    """How far a long computation is."""

    stage: str
    done: int
    total: int
    note: str = ""


def fit(
    problem: Problem,
    tasks: Sequence[Task],
    windows: np.ndarray,
    price: float | Sequence[float],
    *,
    stage: str,
    iterations: int = 8,
    newest_only: bool = False,
    first: bool = False,
) -> Generator[Progress, None, list[Fit]]:
    """Fit hypotheses to windows.

    Args:
        problem: the comparison.
        tasks: hypotheses with the vectors (n_free,) to start from; the best start is pursued.
        windows: indices of the windows.
        price: cost of a value of the model being off by its `spread`, where noise costs 1; one, or one a task.
        stage: what to call it while it goes on.
        iterations: most steps.
        newest_only: move only the parameters of the last claimed place, the others stay and cost nothing: cheap, for a
            first look.
        first: fits that leave much rest early: those worth it will be fitted on.

    Yields:
        Progress after each step.
    """
    prices = list(price) if isinstance(price, Sequence) else [price] * len(tasks)
    if newest_only:
        prices = [0.0] * len(tasks)
    fits, moving, begin = _remembered(problem, tasks, stage) or (*_screened(problem, tasks, windows, prices), 0)
    moving = [i for i in moving if movable(fits[i].hypothesis).any()]
    for iteration in range(begin, iterations):
        _remember(problem, stage, fits, moving, iteration)
        yield Progress(stage, iteration, iterations, _note(fits))
        if not moving:
            break
        found = _iterated([fits[i] for i in moving], problem, windows, [prices[i] for i in moving], newest_only)
        still = []
        for i, (new, rests) in zip(moving, found, strict=True):
            small = _ROUGHLY if first and new.cost > FAR**2 else _CONVERGED
            if not rests and new.cost < fits[i].cost * (1.0 - small):
                still.append(i)
            fits[i] = new
        moving = still
    _remember(problem, stage, fits, moving, iterations)
    yield Progress(stage, iterations, iterations, _note(fits))
    return fits


def _remember(problem: Problem, stage: str, fits: list[Fit], moving: list[int], iteration: int) -> None:
    """Note a stage's state, from which an interrupted explanation goes on."""
    problem.memory[stage] = {
        "iteration": iteration,
        "vectors": [f.vector for f in fits],
        "costs": [f.cost for f in fits],
        "moving": list(moving),
        "robot_steps": problem.counted[0],
    }


def _remembered(problem: Problem, tasks: Sequence[Task], stage: str) -> tuple[list[Fit], list[int], int] | None:
    """What an earlier attempt at this stage came to, if there was one."""
    noted = problem.memory.get(stage)
    if noted is None:
        return None
    problem.counted[0] = max(problem.counted[0], noted["robot_steps"])
    found = zip(tasks, noted["vectors"], noted["costs"], strict=True)
    return [Fit(h, vector, cost) for (h, _), vector, cost in found], noted["moving"], noted["iteration"]


def _note(fits: list[Fit]) -> str:
    best = min(fits, key=lambda f: f.cost)
    return f"{best.hypothesis.label}, error {np.sqrt(best.cost):.4f}"


def _screened(
    problem: Problem, tasks: Sequence[Task], windows: np.ndarray, prices: Sequence[float]
) -> tuple[list[Fit], list[int]]:
    """The best of several starts for each hypothesis, and the indices of those still to be improved: all."""
    starts = [(h, v) for h, vectors in tasks for v in vectors]
    owner = np.repeat(np.arange(len(tasks)), [len(vectors) for _, vectors in tasks])
    costs = _costs(problem, starts, windows, [prices[int(i)] for i in owner])
    best = [int(np.flatnonzero(owner == i)[np.argmin(costs[owner == i])]) for i in range(len(tasks))]
    return [Fit(*starts[b], float(costs[b])) for b in best], list(range(len(tasks)))


def _costs(
    problem: Problem,
    members: Sequence[tuple[Hypothesis, np.ndarray]],
    windows: np.ndarray,
    prices: Sequence[float],
) -> np.ndarray:
    data = _data_costs(problem.residuals(members, windows), problem.parting)
    return data + np.array([prior_cost(h, v, price) for (h, v), price in zip(members, prices, strict=True)])


def _data_costs(residuals: np.ndarray, parting: bool) -> np.ndarray:
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


@dataclass
class _Walk:
    """A fit on its way: where it is, and what is known of the slopes there.

    Attributes:
        at: where.
        moving: (n_free,) which parameters move.
        residual, derivative: (windows, samples), (windows, samples, n_free).
        price: of unusual values.
        goes_on: whether another step with these derivatives may pay.
        rests: whether no step would.
        leaps: whether steps are tried that no slope tells of.
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
    weights: np.ndarray | None = None

    def candidates(self) -> list[np.ndarray]:
        """Where a step may lead."""
        weights = 1.0 if self.weights is None else self.weights[:, None]
        residual, derivative = weights * self.residual, np.expand_dims(weights, -1) * self.derivative
        slopes = normal_equations(self.at, self.price, residual, derivative)
        return candidates(self.at, self.moving, *slopes) + (self._leaps() if self.leaps else [])

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
        hypothesis, costs = self.at.hypothesis, _data_costs(residuals, self.weights is not None)
        costs += [prior_cost(hypothesis, v, self.price) for v in vectors]
        best = int(np.argmin(costs))
        new = Fit(hypothesis, vectors[best], float(costs[best]))
        if new.cost >= self.at.cost:
            self.goes_on = False
            return
        step, shown = new.vector - self.at.vector, residuals[best].astype(np.float64)
        expected = self.residual + self.derivative @ step
        foreseen = self.at.cost - np.sum(expected**2) - prior_cost(hypothesis, new.vector, self.price)
        small = _CONVERGED * self.at.cost
        self.rests = self.at.cost - new.cost < small and foreseen < 2.0 * small
        self.goes_on = self.at.cost - new.cost >= small
        weight = np.einsum("wsn,wsn->n", self.derivative, self.derivative) * step
        if weight @ step > 0.0:
            self.derivative += (shown - expected)[..., None] * (weight / (weight @ step))
        self.at, self.residual = new, shown


def _iterated(
    fits: list[Fit], problem: Problem, windows: np.ndarray, prices: Sequence[float], newest_only: bool
) -> list[tuple[Fit, bool]]:
    """Levenberg-Marquardt steps of each fit, with derivatives found once; and whether it rests.

    A fit that finds nothing better stays.
    """
    moving = [_newest(f.hypothesis) if newest_only else movable(f.hypothesis) for f in fits]
    slopes = jacobians(problem, fits, windows, moving)
    parting = problem.parting
    walks = [
        _Walk(f, m, *s, price, leaps=parting and newest_only, weights=heeded(f, s[1]) if parting else None)
        for f, m, s, price in zip(fits, moving, slopes, prices, strict=True)
    ]
    for _ in range(1 if newest_only else _STEPS_EACH):
        going = [w for w in walks if w.goes_on]
        if not going:
            break
        tried = [w.candidates() for w in going]
        members = [(w.at.hypothesis, v) for w, vectors in zip(going, tried, strict=True) for v in vectors]
        residuals = problem.residuals(members, windows)
        for i, (w, vectors) in enumerate(zip(going, tried, strict=True)):
            w.step_to(vectors, residuals[i * len(vectors) : (i + 1) * len(vectors)])
    return [(w.at, w.rests) for w in walks]


def heeded(fitted: Fit, derivative: np.ndarray) -> np.ndarray:
    """Weights (windows,) of slopes: less than 1 in windows whose slopes are many times as steep as is usual.

    There the robot parts for good from one that differs by a finite-difference step.
    """
    sizes = np.array([f.spread if np.isfinite(f.spread) else 0.1 * f.size for f in fitted.hypothesis.free])
    steep = np.sqrt(np.einsum("wsn,n->w", derivative**2, sizes**2))
    usual = float(np.median(steep))
    return np.minimum(1.0, _STEEP * usual / np.maximum(steep, 1e-30)) if usual > 0.0 else np.ones(len(steep))


def _newest(hypothesis: Hypothesis) -> np.ndarray:
    """Which parameters (n_free,) belong to the place claimed last."""
    own = np.array([(f.effect, f.site) == hypothesis.places[-1] for f in hypothesis.free], dtype=bool)
    return own & movable(hypothesis)
