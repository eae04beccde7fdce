"""The placebo is wrong, has as many parameters where it can, and is fitted, judged and told like the others."""

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import Hypothesis, claiming
from estexp_jax.discovery.placebo import placebo
from estexp_jax.discovery.selection import Explanation, Selection
from estexp_jax.discovery.slopes import Fit
from tests.discovery.planted import nominal

ROBOT, OWN = nominal("two"), Hypothesis((), ())
COULOMB, STRIBECK = ("coulomb_friction", "elbow"), ("stribeck_friction", "elbow")
DRAG, MASS, TILT = ("quadratic_drag", "shoulder"), ("body_mass", "lower"), ("gravity_tilt", "")
LIMIT = ("joint_stiffness", "shoulder")


def explained(error: float, *places, value: float = 0.5) -> Explanation:
    hypothesis = claiming(ROBOT, OWN, places)
    fitted = Fit(hypothesis, np.full(len(hypothesis.free), value), error**2)
    return Explanation(fitted, np.full(4, error**2 / 4.0))


def selected(chosen: Explanation, *others: Explanation) -> Selection:
    own = explained(9.0)
    return Selection(own, own, own, (*others, chosen), chosen)


def wrong(chosen: Explanation, *others: Explanation) -> tuple:
    task = placebo(ROBOT, OWN, selected(chosen, *others))
    return task[0].places if task else ()


def test_it_is_the_best_other_effect():
    assert wrong(explained(1.0, COULOMB), explained(3.0, DRAG), explained(2.0, MASS)) == (MASS,)


def test_a_richer_form_of_the_claimed_law_is_not_wrong_unless_there_is_nothing_else():
    assert wrong(explained(1.0, COULOMB), explained(1.5, STRIBECK), explained(2.0, MASS)) == (MASS,)
    assert wrong(explained(1.0, COULOMB), explained(1.5, STRIBECK)) == (STRIBECK,)
    damped = explained(1.0, ("viscous_friction", "elbow"))
    assert wrong(damped, explained(1.5, ("back_emf", "knee")), explained(2.0, MASS)) == (MASS,)


def test_what_the_data_cannot_tell_apart_is_not_wrong():
    assert wrong(explained(1.0, COULOMB), explained(1.01, MASS), explained(4.0, DRAG)) == (DRAG,)
    assert wrong(explained(1.0, COULOMB), explained(1.01, MASS)) == ()


def test_it_has_the_nearest_number_of_parameters():
    others = (explained(2.0, MASS), explained(5.0, LIMIT))
    assert wrong(explained(1.0, TILT), *others) == (LIMIT,)  # two parameters, like a tilt
    assert wrong(explained(1.0, TILT), others[0]) == (MASS,)


def test_two_claims_are_answered_by_two_wrong_effects_none_of_them_claimed():
    chosen = explained(1.0, COULOMB, DRAG)
    singles = explained(2.0, COULOMB), explained(3.0, MASS), explained(4.0, DRAG), explained(5.0, LIMIT)
    assert wrong(chosen, *singles) == (MASS, LIMIT)
    task = placebo(ROBOT, OWN, selected(chosen, *singles))
    assert task is not None
    assert any(np.all(start == 0.5) for start in task[1])  # as fitted alone


def test_nothing_claimed_nothing_to_answer():
    chosen = explained(1.0)
    assert placebo(ROBOT, OWN, Selection(chosen, chosen, chosen, (explained(2.0, MASS),), chosen)) is None


def test_its_errors_are_told_and_worse_than_the_explanation(diagnosed):
    fit = diagnosed("coulomb_friction@shaft").findings["fit"]
    assert fit["explained"]["test"] < 0.5 * fit["placebo"]["test"]
    assert fit["placebo"]["train"] < fit["nominal"]["train"]


@pytest.mark.parametrize("name", ["nothing"])
def test_where_nothing_is_claimed_there_is_none(name, diagnosed):
    assert diagnosed(name).findings["fit"]["placebo"] == {}
