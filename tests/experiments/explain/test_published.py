"""The board of published values: what counts as right, as inside, as a wrong name."""

from typing import Any

import pytest

from experiments.explain.published.board import lines_of, wrong_names
from experiments.explain.published.values import MACHINES


def _claim(effect: str, name: str, value: float, reach: float, probability: float = 0.9) -> dict[str, Any]:
    parameter = {"viscous_friction": "c", "coulomb_friction": "T", "joint_jam": "f"}[effect]
    numbers = {parameter: {"value": value, "low": value - reach, "high": value + reach}}
    return {"effect": effect, "kind": "joint", "name": name, "parameters": numbers, "probability": probability}


def test_a_value_is_right_within_a_quarter_and_inside_its_interval() -> None:
    what = [_claim("viscous_friction", "axis", 170.0, 20.0), _claim("coulomb_friction", "axis", 40.0, 30.0)]
    viscous, dry, offset = lines_of(MACHINES["emps"], {"what": what})
    assert viscous.right and not viscous.inside
    assert dry.inside and not dry.right
    assert offset.found is None and not offset.right


def test_a_regression_of_the_torques_counts_as_well_as_the_published_value() -> None:
    what = [_claim("coulomb_friction", "joint_6", 2.6, 0.1)]
    [line] = [line for line in lines_of(MACHINES["tx40"], {"what": what}) if line.found]
    assert line.published.regression == pytest.approx(2.61) and line.right and line.inside


def test_names_at_other_places_and_of_other_kinds_are_wrong_where_they_are_sure() -> None:
    sure, unsure = _claim("joint_jam", "axis", 0.7, 0.1), _claim("joint_jam", "axis", 0.7, 0.1, probability=0.4)
    right = _claim("viscous_friction", "axis", 170.0, 20.0)
    assert wrong_names(MACHINES["emps"], {"what": [sure, right]}) == ["joint_jam@axis"]
    assert wrong_names(MACHINES["emps"], {"what": [unsure, right]}) == []
