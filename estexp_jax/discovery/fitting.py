"""Fitting many hypotheses at once: bounded Levenberg-Marquardt on finite differences, all of it in batched replays.

The damping is chosen each time among four candidates simulated together, which costs no extra round trip. Derivatives
by many values cost most; so some steps are taken with those of the last point, mended by what the step showed.

Sources: Nocedal and Wright, Numerical Optimization (2006), chapter 10; Madsen, Nielsen and Tingleff, Methods for
Non-Linear Least Squares Problems (2004), section 3.5 (the secant version).
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from typing import NamedTuple

import numpy as np

from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.slopes import Fit, jacobians, movable, prior_cost
from estexp_jax.discovery.walks import CONVERGED, Walk, data_costs, heeded

FAR, _ROUGHLY = 10.0, 1e-2
"""Deviations beyond which a fit leaves so much that a first one may rest at this relative fall of the cost."""
_STEPS_EACH = 4
"""Most steps with derivatives found once."""

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
            small = _ROUGHLY if first and new.cost > FAR**2 else CONVERGED
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
        "claims": [f.hypothesis.label for f in fits],
        "iteration": iteration,
        "vectors": [f.vector for f in fits],
        "costs": [f.cost for f in fits],
        "moving": list(moving),
        "robot_steps": problem.counted[0],
    }


def _remembered(problem: Problem, tasks: Sequence[Task], stage: str) -> tuple[list[Fit], list[int], int] | None:
    """What an earlier attempt at this stage came to, if there was one that fitted the same hypotheses.

    Another version of the program may have come to a stage of the same name by another way.
    """
    noted = problem.memory.get(stage)
    if noted is None or noted.get("claims") != [h.label for h, _ in tasks]:
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
    data = data_costs(problem.residuals(members, windows), problem.parting)
    return data + np.array([prior_cost(h, v, price) for (h, v), price in zip(members, prices, strict=True)])


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
        Walk(
            *(f, m, *s, price),
            leaps=parting and newest_only,
            rescales=not newest_only,
            weights=heeded(f, s[1]) if parting else None,
        )
        for f, m, s, price in zip(fits, moving, slopes, prices, strict=True)
    ]
    for _ in range(1 if newest_only else _STEPS_EACH):
        going = [w for w in walks if w.goes_on]
        if not going:
            break
        tried = [w.candidates() for w in going]
        members = [(w.at.hypothesis, v) for w, vectors in zip(going, tried, strict=True) for v in vectors]
        residuals = problem.residuals(members, windows)
        own = np.split(residuals, np.cumsum([len(vectors) for vectors in tried])[:-1])
        for w, vectors, left in zip(going, tried, own, strict=True):
            w.step_to(vectors, left)
    return [(w.at, w.rests) for w in walks]


def _newest(hypothesis: Hypothesis) -> np.ndarray:
    """Which parameters (n_free,) belong to the place claimed last."""
    own = np.array([(f.effect, f.site) == hypothesis.places[-1] for f in hypothesis.free], dtype=bool)
    return own & movable(hypothesis)
