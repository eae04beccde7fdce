"""What is told where nothing explains a mismatch."""

from dataclasses import replace
from typing import Any, cast

import numpy as np
import pytest

from estexp_jax.discovery.diagnosis import Case
from estexp_jax.discovery.findings import noise_advice
from estexp_jax.discovery.findings_json import Found, judged_by, needless
from estexp_jax.discovery.hypotheses import Hypothesis, claiming, parameters_only
from estexp_jax.discovery.selection import Explanation, Selection
from estexp_jax.discovery.shown import Shown
from estexp_jax.discovery.slopes import Fit
from estexp_jax.physics.effects.registry import catalogue
from tests.discovery.planted import Plant, case_of, nominal, problem_of

UNUSED: Any = None


def fit(number: float) -> Fit:
    return Fit(Hypothesis((), ()), np.zeros(0), number)


def explanation(error: float) -> Explanation:
    """With errors that differ from window to window."""
    share = np.array([0.5, 0.8, 1.0, 1.1, 1.3, 1.3])
    return Explanation(fit(error**2), error**2 * share / share.sum())


@pytest.mark.parametrize(("before", "bent", "kept"), [(10.0, 9.9, False), (10.0, 6.0, True), (60.0, 30.0, False)])
def test_where_nothing_explains_values_stay_unless_bending_them_pays(before: float, bent: float, kept: bool) -> None:
    """Nor are they bent where much is left even so: what they were bent by then is other motions' error."""
    robot = nominal("one")
    as_it_is, own = explanation(before), explanation(bent)
    selection = Selection(as_it_is, as_it_is, own, (), own)
    fits = {name: fit(float(i)) for i, name in enumerate(("nominal", "explained", "sayable", "parameters_only"))}
    found = Found(UNUSED, UNUSED, selection, fits, {}, ())
    judged, after, step = judged_by(Case(robot, (), ()), found)
    assert judged == "unexplained" and step is None
    assert after.fits["parameters_only"] is fits["parameters_only"]
    shown = "explained" if kept else "nominal"
    assert after.fits["explained"] is fits[shown] and after.fits["sayable"] is fits["sayable" if kept else "nominal"]


@pytest.mark.parametrize(("stepless", "own_step"), [(9.9, True), (4.0, False)])
def test_what_stays_as_it_is_keeps_its_step_unless_a_finer_one_pays(stepless: float, own_step: bool) -> None:
    nominal_one, own = explanation(10.0), explanation(9.9)
    selection = Selection(nominal_one, explanation(stepless), own, (), own)
    fits = {name: fit(float(i)) for i, name in enumerate(("nominal", "explained", "sayable", "parameters_only"))}
    _, after, _ = judged_by(Case(nominal("one"), (), ()), Found(UNUSED, UNUSED, selection, fits, {}, ()))
    assert after.fits["explained"] is fits["nominal"] and after.own_step == own_step


class Errors:
    """Of simulators beside recordings, whatever the windows."""

    def __init__(self, **errors: float) -> None:
        self.error = lambda name, _: errors[name]
        self.problem = self
        self.windows_of = lambda _: np.arange(2)


@pytest.mark.parametrize(("with_claims", "wanted"), [(0.0143, True), (0.0119, False)])
def test_claims_beside_which_values_predict_no_better_are_not_handed_over(with_claims: float, wanted: bool) -> None:
    """Seen: a motor that fades, `unexplained`; an armature had been tried, and test recordings were worse for it."""
    robot = nominal("one")
    own = parameters_only(robot, catalogue(["armature"]))
    claim = claiming(robot, own, [("armature", "shaft")])
    before, shown = explanation(10.0), cast(Shown, Errors(parameters_only=0.0120, explained=with_claims))
    for hypothesis, claims in ((claim, True), (own, False)):
        fits = {"explained": Fit(hypothesis, hypothesis.start(), 1.0)}
        found = Found(UNUSED, UNUSED, Selection(before, before, before, (), before), fits, {}, ())
        assert needless(Case(robot, (), ()), found, shown) is (wanted and claims)


@pytest.mark.parametrize(("loud", "told"), [(1.0, 1), (0.01, 0)])
def test_a_reading_that_swings_faster_than_its_rows_is_told(loud: float, told: int) -> None:
    problem = problem_of(case_of("two", Plant(), 12, trains=1))
    noise = problem.noise.copy()
    noise[0, 1] = loud * np.ptp(problem.recordings[0].sensor[:, 1])
    lines = noise_advice(replace(problem, noise=noise))
    assert len(lines) == told and all("lower_angle" in line and "100%" in line for line in lines)
