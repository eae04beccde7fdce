"""Claims of one effect at one place are told as one."""

from typing import Any

import pytest

from estexp_jax.discovery.merged_claims import merged_claims
from estexp_jax.physics.model.robot import Robot

_ROBOT = Robot.from_string(
    """<mujoco><worldbody><body><joint name="axis" type="slide" axis="1 0 0"/><geom size=".1"/></body></worldbody>
    <actuator><motor name="drive" joint="axis"/></actuator></mujoco>""",
    "drive",
)


def _dry(value: float, low: float | None, high: float, probability: float, **others: float) -> dict[str, Any]:
    numbers = {"T": {"value": value, "low": low, "high": high, "unit": "N"}}
    numbers |= {name: {"value": v, "low": v, "high": v, "unit": ""} for name, v in others.items()}
    return {
        "effect": "coulomb_friction",
        "kind": "joint",
        "name": "axis",
        "probability": probability,
        "in_mjcf": True,
        "sentence": "",
        "equation": "",
        "parameters": numbers,
    }


def test_amounts_of_two_forms_add_and_so_do_their_variances():
    [told] = merged_claims(_ROBOT, [_dry(19.0, 16.0, 22.0, 0.9), _dry(2.0, -2.0, 6.0, 0.4, a=0.1)])
    numbers = told["parameters"]["T"]
    assert (numbers["value"], numbers["low"], numbers["high"]) == pytest.approx((21.0, 16.0, 26.0))
    assert told["probability"] == 0.9
    assert told["parameters"]["a"]["value"] == 0.1
    assert "21 N" in told["sentence"]


def test_an_end_that_one_form_does_not_know_is_not_known_of_the_sum():
    [told] = merged_claims(_ROBOT, [_dry(19.0, None, 22.0, 0.9), _dry(2.0, 1.0, 3.0, 0.4)])
    assert told["parameters"]["T"]["low"] is None


def test_other_effects_other_places_and_laws_stay_as_they_are():
    other = {**_dry(1.0, 0.0, 2.0, 0.5), "effect": "viscous_friction"}
    elsewhere = {**_dry(1.0, 0.0, 2.0, 0.5), "name": "wrist"}
    entries = [_dry(1.0, 0.0, 2.0, 0.5), other, elsewhere]
    assert merged_claims(_ROBOT, entries) == entries
