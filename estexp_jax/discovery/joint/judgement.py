"""A joint fit on held-out windows, among what competes with it: nothing, values alone, less of it, and rivals."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from estexp_jax.discovery.cross_validation import as_fitted
from estexp_jax.discovery.hypotheses import Hypothesis, claiming
from estexp_jax.discovery.joint.fit import JointSearch
from estexp_jax.discovery.joint.reading_stage import JointFit, without
from estexp_jax.discovery.location import element
from estexp_jax.discovery.placebo import placebo
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import NOISE, Fold, Selection, folds_of
from estexp_jax.discovery.slopes import Fit
from estexp_jax.estimation.parameters import ParameterSpace, Place
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot


class Judged(NamedTuple):
    """A joint fit among what competes with it.

    Attributes:
        selection: with what was chosen.
        fits: by what they are called in findings.
        problem: the comparison about it.
        folds: of its windows.
    """

    selection: Selection
    fits: dict[str, Fit]
    problem: Problem
    folds: list[Fold]


def judged_alone(whole: Problem, search: JointSearch, parameters: Hypothesis, fit: JointFit, bent: JointFit) -> Judged:
    """A joint fit, judged among nothing, values alone, and less of it."""
    robot, space = whole.replayer.robot, search.space
    nominal = Fit(parameters, parameters.start(), np.inf)
    explained = as_fit(robot, space, parameters, fit, fit.places)
    own = as_fit(robot, space, parameters, bent, ())
    heard = replace(whole.heard(explained.member), lacking=search.problem.lacking)
    problem, unchanged = heard.about(explained.member), heard.about(nominal.member)
    folds = folds_of(problem)
    less = [as_fit(robot, space, parameters, fit, kept) for kept in _with_fewer(robot, fit.places)]
    plain = replace(unchanged, rough=None)
    kinds = (replace(plain, step=None), plain, unchanged)
    as_it_is, mended, doubted = (as_fitted(p, [nominal], folds)[0] for p in kinds)
    corrected = doubted if doubted.error <= NOISE else mended  # but for the step's doubt, where nothing else is left
    found = as_fitted(problem, [own, *less, explained], folds)
    selection = Selection(as_it_is, corrected, found[0], tuple(found[1:]), found[-1])
    sayable = [p for p in fit.places if effect(p[0]).in_mjcf]
    fits = {
        "parameters_only": own,
        "nominal": nominal,
        "explained": explained,
        "sayable": as_fit(robot, space, parameters, fit, sayable),
    }
    return Judged(selection, fits, problem, folds)


def judged_beside(judged: Judged, search: JointSearch, parameters: Hypothesis, rivals: Sequence[JointFit]) -> Judged:
    """The same with rivals among what competes, and with its placebo."""
    robot, (*less, chosen) = judged.problem.replayer.robot, judged.selection.tried
    others = [as_fit(robot, search.space, parameters, other, other.places) for other in rivals]
    found = as_fitted(judged.problem, others, judged.folds)
    selection = replace(judged.selection, tried=(*less, *found, chosen))
    wrong = placebo(robot, parameters, selection)
    tried = {e.places: e.fitted for e in selection.tried}
    fits = judged.fits
    if wrong and wrong[0].places in tried:
        fits = {**fits, "placebo": tried[wrong[0].places]}
    return judged._replace(selection=selection, fits=fits)


def _with_fewer(robot: Robot, places: Sequence[Place]) -> list[tuple[Place, ...]]:
    """The places less one effect each, and less all effects of one element each: how much either explains."""
    each = [tuple(p for p in places if p != place) for place in places]
    elements = dict.fromkeys(element(robot, place) for place in places)
    each += [tuple(p for p in places if element(robot, p) != e) for e in elements]
    return [kept for kept in dict.fromkeys(each) if kept]


def as_fit(robot: Robot, space: ParameterSpace, parameters: Hypothesis, fit: JointFit, places: Sequence[Place]) -> Fit:
    """A joint fit with some of its effects only, the others' values as they follow from its covariance.

    Args:
        robot: the nominal robot.
        space: of the fit's point.
        parameters: the hypothesis that only values of the model are off.
        fit: the joint fit.
        places: those of its effects that are kept.
    """
    point = without(space, fit, [p for p in fit.places if p not in places])
    hypothesis = claiming(robot, parameters, places)
    index = {(p.effect, p.site, p.name): i for i, p in enumerate(space.parameters)}
    free, vector = [], []
    for f in hypothesis.free:
        value = float(point[index[f.effect, f.site, f.parameter]])
        if np.isinf(f.spread):  # bounds of a claim come from what motors could do, which the recordings may exceed
            f = replace(f, low=min(f.low, 2.0 * value), high=max(f.high, 2.0 * value))
        free.append(f)
        vector.append(np.clip(value, f.low, f.high))
    return Fit(Hypothesis(hypothesis.places, tuple(free)), np.array(vector), np.inf)
