"""The fits of a round: roughly where there is much to simulate, to all windows, then each with its own step's error."""

from __future__ import annotations

from collections.abc import Generator, Sequence

import numpy as np

from estexp_jax.discovery.fitting import Progress, Task, fit
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.screening import beside
from estexp_jax.discovery.slopes import Fit

_MANY = 16
"""Windows of which every second one is enough for a rough fit."""
_DONORS = 3
"""So many best fits lend the others their values of the model to start from."""


def fitted(
    problem: Problem, tasks: Sequence[Task], stage: str, iterations: int = 8
) -> Generator[Progress, None, tuple[list[Fit], Problem]]:
    """Hypotheses fitted to all windows, first with the step's error as the comparison has it, then each with its own.

    Returns:
        The fits, and the comparison with their own corrections.
    """
    found = yield from at_first(problem, tasks, stage, iterations)
    return (yield from refitted(problem, found, stage, iterations))


def at_first(
    problem: Problem, tasks: Sequence[Task], stage: str, iterations: int = 8, *, roughly: bool = False
) -> Generator[Progress, None, list[Fit]]:
    """The best fit of each hypothesis, with the step's error as the comparison has it.

    It is fitted to all windows, or roughly, to every second one where there are many; its cost is that of all.
    """
    windows, name = problem.fitted, f"{stage}, at first"
    if roughly and len(windows) >= _MANY:
        some, told = every_second(problem), f"{name}, every second window"
        rough = yield from fit(
            problem, tasks, some, problem.price_of(some), stage=told, iterations=iterations, first=True
        )
        tasks, iterations = [(f.hypothesis, [f.vector]) for f in rough], 0
    price = problem.price_of(windows)
    found = yield from fit(problem, tasks, windows, price, stage=name, iterations=iterations, first=True)
    better = {f.hypothesis: f for f in sorted(found, key=lambda f: f.cost, reverse=True)}
    return [f for f in found if better[f.hypothesis] is f]


def every_second(problem: Problem) -> np.ndarray:
    """Every second fitted window of each recording, from its first or second one by turns.

    Of recordings with two windows each, plainly every second one would be what all motions begin with.
    """
    owner = np.array([problem.segments[w].recording for w in problem.fitted])
    rank = np.array([np.sum(owner[:i] == r) for i, r in enumerate(owner)])
    return problem.fitted[(rank + np.unique(owner, return_inverse=True)[1]) % 2 == 0]


def refitted(
    problem: Problem, fits: Sequence[Fit], stage: str, iterations: int = 8
) -> Generator[Progress, None, tuple[list[Fit], Problem]]:
    """Fits to which the comparison was about something else, fitted on, each with its own step's error.

    They may start from each other's values of the model.
    """
    there = problem.corrected([f.member for f in fits])
    prices = there.prices([f.member for f in fits])
    best = sorted(fits, key=lambda f: f.cost)[:_DONORS]
    tasks: list[Task] = [(f.hypothesis, [f.vector, *(beside(f, d) for d in best if d is not f)]) for f in fits]
    return (yield from fit(there, tasks, there.fitted, prices, stage=stage, iterations=iterations)), there
