"""Which explanations are believed, and how the belief is shared."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.discovery.findings import others
from estexp_jax.discovery.hypotheses import Free, Hypothesis, claiming, parameters_only
from estexp_jax.discovery.selection import Explanation, Selection, probabilities, simplest, steadiest, tied, worth
from estexp_jax.discovery.slopes import Fit
from estexp_jax.physics.effects.registry import catalogue
from tests.discovery.planted import nominal


def explanation(held_out, *places):
    return Explanation(Fit(Hypothesis(tuple(places), ()), np.zeros(0), 0.0), np.asarray(held_out, float))


def selection(*tried):
    own = explanation(np.full(12, 4.0))
    return Selection(own, own, own, tried, tried[0])


def test_explanations_that_the_windows_cannot_tell_apart_share_their_probability():
    square = np.random.default_rng(81).uniform(0.08, 0.09, 12)
    one, same, worse = (explanation(square * f, (n, "a")) for f, n in ((1, "x"), (1.001, "y"), (1.5, "z")))
    assert probabilities(selection(one, same, worse), 0) == pytest.approx([0.0, 0.5, 0.5, 0.0])


def test_what_fits_as_well_with_no_more_effects_is_tied():
    square = np.random.default_rng(83).uniform(0.08, 0.09, 12)
    chosen, richer, beside, worse = (
        explanation(square * f, *((n, "a") for n in names))
        for f, names in ((1.0, "x"), (1.001, "y"), (0.999, "xy"), (1.1, "z"))
    )
    among = selection(chosen, worse, richer, beside)
    assert tied(richer, chosen) and not tied(worse, chosen)
    assert not tied(beside, chosen), "the chosen one with something beside it is no rival"
    assert not tied(among.parameters, among.parameters), "nothing is claimed"


def test_alternatives_hold_what_is_tied_and_not_what_is_plainly_worse():
    robot = nominal("two")
    own = parameters_only(robot, catalogue(["viscous_friction", "coulomb_friction", "motor_weakness"]))

    def claimed(held_out, *place):
        hypothesis = claiming(robot, own, [place])
        return replace(explanation(held_out), fitted=Fit(hypothesis, hypothesis.with_values(place, [0.2]), 0.0))

    square = np.full(12, 0.08)
    chosen, same, worse = (
        claimed(square * f, *place)
        for f, place in (
            (1.0, ("viscous_friction", "elbow")),
            (1.01, ("coulomb_friction", "elbow")),
            (1.1, ("motor_weakness", "knee")),
        )
    )
    nothing = Explanation(Fit(own, own.start(), 0.0), np.full(12, 4.0))
    among = Selection(nothing, nothing, nothing, (chosen, worse, same), chosen)
    assert [e for e, _ in others(among, np.array([0.0, 1.0, 0.0, 0.0]), 0)] == [same]


def test_the_better_one_on_most_windows_is_the_likelier_one_and_all_add_up():
    rng = np.random.default_rng(82)
    one, other = (explanation(rng.uniform(0.0, 0.2 + more, 12), (n, "a")) for more, n in ((0.0, "x"), (0.06, "y")))
    shares = probabilities(selection(one, other), 0)
    assert shares.sum() == pytest.approx(1.0) and np.all(shares >= 0.0)
    assert shares[1] > shares[2] > 0.0


def test_what_shows_in_few_windows_but_plainly_is_believed():
    before, after = np.full(12, 0.09), np.full(12, 0.0901)
    before[:2], after[:2] = 30.0, 0.3
    assert worth(explanation(after, ("x", "a")), explanation(before))


def test_a_small_gain_must_be_agreed_on_by_the_windows():
    before = np.full(12, 1.0)
    lucky, steady = before.copy(), before * 0.8
    lucky[:3] = 0.1
    lucky[3:] = 1.01
    assert lucky.sum() < 0.85 * before.sum()
    assert not worth(explanation(lucky, ("x", "a")), explanation(before))
    assert worth(explanation(steady, ("x", "a")), explanation(before))
    assert not worth(explanation(before * 0.9, ("x", "a")), explanation(before))
    both = [explanation(lucky, ("x", "a")), explanation(steady, ("y", "a"))]
    assert simplest(both) is both[0] and steadiest(both, explanation(before)) is both[1]
    assert steadiest(both[:1], explanation(before)) is both[0], "none is worth it: the best one stays, to be refused"
    assert replace(explanation(before), held_out=4.0 * before).error == pytest.approx(np.sqrt(48.0))


def test_what_bends_values_far_is_not_simplest_for_having_fewer_of_them():
    """Claiming a value of the model frees none, while an effect has values of its own."""
    bent = replace(explanation(np.full(12, 0.036), ("armature", "a")), unusual=0.09)
    own = replace(explanation(np.full(12, 0.0355), ("sensor_bias", "a")), unusual=0.001)
    free = Free("sensor_bias", "a", "bias", 0, 0, -1.0, 1.0, 0.0, np.inf)
    own = replace(own, fitted=replace(own.fitted, hypothesis=Hypothesis((("sensor_bias", "a"),), (free,))))
    assert simplest([bent, own]) is own
    assert simplest([replace(bent, unusual=0.001), own]) is not own
    loud = [replace(e, held_out=100.0 * e.held_out, unusual=100.0 * e.unusual) for e in (bent, own)]
    assert simplest(loud) is loud[0], "far from any explanation, what is bent tells little"


def test_a_value_that_is_bent_far_costs_as_much_as_an_effect():
    """Else many values that are off by a quarter each are as probable as the one thing that is missing."""
    free = [Free("viscous_friction", site, "c", i, 0, -0.3, 0.3, 0.0, 0.03) for i, site in enumerate("abc")]
    square = np.full(12, 0.08)
    claim = explanation(square, ("viscous_friction", "a"))

    def shares(*vector):
        own = Explanation(Fit(Hypothesis((), tuple(free)), np.array(vector), 0.0), square)
        return probabilities(Selection(own, own, own, (claim,), claim), 0)

    assert shares(0.1, -0.1, 0.1) == pytest.approx([1.0, 0.0])
    assert shares(0.28, -0.28, 0.1) == pytest.approx([0.0, 1.0])
