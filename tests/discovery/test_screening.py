"""Which of many hypotheses are looked at longer."""

import numpy as np

from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.screening import with_rungs
from estexp_jax.discovery.slopes import Fit


def _ranked(*effects: str) -> list[Fit]:
    return [Fit(Hypothesis(((name, "knee"),), ()), np.zeros(0), float(i)) for i, name in enumerate(effects)]


def _names(fits: list[Fit]) -> list[str]:
    return [f.hypothesis.places[-1][0] for f in fits]


def test_forms_of_one_effect_take_one_place() -> None:
    ranked = _ranked("outer_backlash", "cogging", "backlash", "viscous_friction", "armature")
    assert _names(with_rungs(ranked, 2)) == ["outer_backlash", "cogging", "backlash"]
    assert _names(with_rungs(ranked, 3)) == ["outer_backlash", "cogging", "backlash", "viscous_friction"]


def test_a_richer_law_brings_the_simpler_one_that_it_contains() -> None:
    ranked = _ranked("quadratic_drag", "cogging", "torque_offset", "viscous_friction")
    assert _names(with_rungs(ranked, 2)) == ["quadratic_drag", "cogging", "viscous_friction"]


def test_forms_at_other_sites_are_others() -> None:
    here, there = ("backlash", "knee"), ("outer_backlash", "hip")
    ranked = [Fit(Hypothesis((place,), ()), np.zeros(0), 0.0) for place in (here, there)]
    assert [f.hypothesis.places[-1] for f in with_rungs(ranked, 1)] == [here]
