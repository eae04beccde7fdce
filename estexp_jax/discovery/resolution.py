"""How small an error still means something: below it, noise and guessed start states hide everything."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estexp_jax.discovery.diagnosis import Case, ExplainConfig
from estexp_jax.discovery.problem import Member, Problem
from estexp_jax.inference.windows import segments_of

_OTHER_DEGREE = 2
"""Start states read from polynomials of this degree, not 3, are the second opinion: worse than the first where servos
jolt, never wild under noise (degree 5 was)."""


def resolution(case: Case, config: ExplainConfig, problem: Problem, member: Member, floor: float) -> float:
    """The error that a right simulator may have on training windows, an nrmse: noise and uncertain start states.

    Every window starts from a state read from noisy samples through a polynomial. Two degrees of it give two states,
    as in embedded Runge-Kutta pairs; how far the simulations from them are apart is how far the worse may be off.

    Args:
        case: what is explained.
        config: how.
        problem: the comparison.
        member: the simulator to start twice.
        floor: what noise alone gives, an nrmse.
    """
    windows = problem.windows_of(case.indices("train"))
    other = tuple(segments_of(case.robots, case.recordings, config.window, degree=_OTHER_DEGREE))
    pair = [p.residuals([member], windows)[0] for p in (problem, replace(problem, segments=other))]
    return float(np.sqrt(floor**2 + np.sum(np.square(pair[1] - pair[0], dtype=np.float64))))
