"""A sensor that shows one value while everything says that its joint moves.

What the joint really did then is not known, nor, where no servo holds it, where it is when a window starts. So
nothing predicts the other sensors well, and no comparison of predictions would ever name what anyone sees.
"""

from __future__ import annotations

import math

import numpy as np

from estexp_jax.discovery.cross_validation import as_fitted
from estexp_jax.discovery.hypotheses import Hypothesis, claiming
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import Explanation, Selection, folds_of
from estexp_jax.discovery.slopes import Fit
from estexp_jax.physics.effects.registry import effect

_MOVES = 20.0
"""Deviations of its noise by which a reading must be simulated to move in half of the windows."""
PLAIN = math.erfc(_MOVES / math.sqrt(2.0))
"""Probability that noise alone hides such a move in one sample: the p-value of a sensor that is seen to be stuck."""


def frozen(problem: Problem, parameters: Hypothesis, selection: Selection) -> Explanation | None:
    """The explanation by a sensor that is stuck and should move; None where there is none.

    Only for what nothing else explains: a joint that is jammed does not move either, but then the other sensors agree.

    Args:
        problem: the comparison.
        parameters: the hypothesis that only values of the model are off.
        selection: what was tried.
    """
    robot, names = problem.replayer.robot, problem.channels.names
    [simulated] = problem.simulated([selection.nominal.fitted.member], problem.fitted)
    known = np.isfinite(simulated)
    spread = np.ma.masked_array(simulated, ~known).std(axis=1).filled(np.inf)  # of what blew up, or has no sample
    moved = spread / problem.recorded.deviation(problem.fitted, 1)[:, 0]
    for place in problem.places:  # a sensor that moves has no such place
        if not effect(place[0]).masks_readings or place[1] not in names:
            continue
        shown = problem.seen.reading[int(robot.model.sensor_adr[robot.index("sensor", place[1])])]
        if not np.isfinite(shown) or np.median(moved[:, names.index(place[1])]) < _MOVES:
            continue
        hypothesis = claiming(robot, parameters, [place])
        vector = hypothesis.start()
        vector[[(f.effect, f.site) == place for f in hypothesis.free]] = shown
        return as_fitted(problem, [Fit(hypothesis, vector, np.inf)], folds_of(problem))[0]
    return None
