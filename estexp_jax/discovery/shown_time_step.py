"""The step at which an explained simulator is shown: so fine that noise hides what is left of the step's error."""

from __future__ import annotations

from dataclasses import replace

import mujoco
import numpy as np

from estexp_jax.discovery.diagnosis import Case
from estexp_jax.discovery.problem import Member, Problem
from estexp_jax.estimation.windows import FINER

_PARTS = (FINER, 2 * FINER, 4 * FINER)
"""Parts of the model's own step to choose from."""
_HIDDEN = 0.5
"""Deviations of noise that the step may be off by, in the middle one of the windows."""
_WORK = 1_000_000
"""Most robot steps of one simulation of all windows; coarser steps are taken rather."""


def resolved(case: Case, problem: Problem, shown: Problem, member: Member) -> Problem:
    """The comparison that is shown, at the coarsest step that will do; test recordings have no say in it.

    Fits need no fine step, since what it would change is reckoned out of them. But whoever takes the explained
    simulator has it at one step, and the step acts like a delay of half its length. A robot that was simulated itself
    has a step of its own, which is the best.

    Args:
        case: what was explained.
        problem: the comparison that was fitted.
        shown: the comparison as the results show it.
        member: the explained simulator.
    """
    own, steps = step_error(problem, member), sum(s.steps.n_steps for s in shown.segments)
    left = {n: own * abs(1.0 / n - (1.0 - problem.lacking)) for n in _PARTS if n == FINER or n * steps <= _WORK}
    parts = next((n for n, error in left.items() if error <= _HIDDEN), min(left, key=lambda n: left[n]))
    whole = [float(robot.model.opt.timestep) for robot in case.robots]
    cut = shown.replays.cut.finer(whole, parts)
    return replace(shown, replays=replace(shown.replays, cut=cut))


def step_error(problem: Problem, member: Member) -> float:
    """By how many deviations of noise the model's own step moves readings, in the middle one of the fitted windows.

    Not in their mean: where bodies touch, steps of any length part for good.
    """
    if int(problem.replayer.robot.model.opt.integrator) == int(mujoco.mjtIntegrator.mjINT_RK4):
        return 0.0  # its error falls so fast that no finer step is needed
    _, [change] = problem.replays.steps([member], problem.fitted)
    moved = np.square(change / problem.recorded.deviation(problem.fitted, change.shape[1]))
    sampled = np.isfinite(problem.recorded.readings(problem.fitted))
    return float(np.sqrt(np.median([m[s].mean() for m, s in zip(moved, sampled, strict=True) if s.any()])))
