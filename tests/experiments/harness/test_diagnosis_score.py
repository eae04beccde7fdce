"""How right a diagnosis is."""

import pytest

from estexp_jax.physics.effects.changes import Change
from experiments.harness.diagnosis_score import amount_error, same_set
from experiments.harness.world import quadruped

WEAK = Change("motor_weakness", "hip_f", {"loss": 0.5})


def test_a_diagnosis_is_right_where_every_change_and_place_is() -> None:
    less = Change("motor_weakness", "hip_f", {"loss": 0.53})
    assert same_set([WEAK], [less]) and not same_set([WEAK], [less, Change("gravity_tilt", None, {"angle": 0.1})])
    assert amount_error(quadruped(), [WEAK], [less]) == pytest.approx(3.0)
    assert amount_error(quadruped(), [WEAK], []) is None
    ties = [Change("tied_outputs", "hip_f", {"with": w}) for w in (2.0, 3.0)]
    assert same_set(ties[:1], ties[:1]) and not same_set(ties[:1], ties[1:])


def test_mass_errors_are_shares_of_the_nominal_mass() -> None:
    nominal = float(quadruped().model.body_mass[quadruped().index("body", "torso")])
    masses = [Change("body_mass", "torso", {"dm": x * nominal}) for x in (1.0, 0.9)]
    assert amount_error(quadruped(), masses[:1], masses[1:]) == pytest.approx(10.0)
