"""What was wrong already when a robot was healthy is no news; what changed since is told, from what to what."""

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from estexp_jax.discovery.baseline import Baseline, baseline_of, changed_entry, explain_change
from estexp_jax.discovery.diagnosis import Prediction
from estexp_jax.discovery.hypotheses import batch, claiming, parameters_only
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import catalogue
from tests.discovery.planted import CONFIG, Plant, case_of, finished, nominal

LOOSE = 'damping="0.02"'
WELL = Plant(LOOSE, f'{LOOSE} frictionloss="0.06"', delay=0.03)
NOW = Plant(LOOSE, f'{LOOSE} frictionloss="0.16"', delay=0.03)
FRICTION, DELAY = Change("coulomb_friction", "shaft", {"T": 0.06}), Change("command_delay", "servo", {"delay": 0.03})


def _entry(effect: str, kind: str, name: str, parameter: str, value: float, unit: str) -> dict[str, Any]:
    numbers = {parameter: {"value": value, "low": value - 0.01, "high": None, "unit": unit}}
    told = {"probability": 0.9, "in_mjcf": True, "sentence": "as told", "equation": "as told"}
    return {"effect": effect, "kind": kind, "name": name, "parameters": numbers, **told}


def _baseline(*changes: Change, **discrepancy: float) -> Baseline:
    return Baseline(changes, 1, discrepancy, {"what": [], "verdict": "consistent", "data": []})


def test_what_mjcf_holds_is_written_and_the_rest_stands_under_every_hypothesis():
    case = case_of("one", Plant(), 21, trains=1, tests=1, length=0.5)
    well = _baseline(FRICTION, DELAY, angle=0.01).of(case)
    assert well.robot.model.dof_frictionloss[0] == pytest.approx(0.06)
    assert {id(r) for r in well.robots} == {id(well.robot)}  # of the one model, compiled once
    assert well.standing == (DELAY,) and well.discrepancy == {"angle": 0.01}
    assert case.robot.model.dof_frictionloss[0] == 0.0 and not case.standing


def test_claims_add_to_what_stands():
    robot, effects = nominal("one"), catalogue(["command_delay", "coulomb_friction"])
    nothing = parameters_only(robot, effects)
    delayed = claiming(robot, nothing, [("command_delay", "servo")])
    vector = delayed.with_values(("command_delay", "servo"), [0.01])
    values = batch(robot, effects, [(nothing, nothing.start()), (delayed, vector)], (DELAY,))
    row = [values["command_delay"][k].max() for k in (0, 1)]
    assert row == pytest.approx([0.03, 0.04])


@pytest.mark.parametrize(
    ("entry", "was", "now", "words"),
    [
        (_entry("coulomb_friction", "joint", "shaft", "T", 0.1, "N m"), 0.06, 0.16, "T was 0.06 N m"),
        (_entry("armature", "joint", "shaft", "I", 0.02, "kg m2"), 0.0, 0.02, "I was 0 kg m2"),
        (_entry("motor_weakness", "actuator", "servo", "loss", 0.5, ""), 0.2, 0.6, "loss was 0.2 when"),
    ],
)
def test_a_change_is_told_from_what_to_what(entry, was, now, words):
    weak = Change("motor_weakness", "servo", {"loss": 0.2})
    told = changed_entry(nominal("one"), entry, _baseline(FRICTION, weak))
    [number] = told["parameters"].values()
    assert number["from"] == pytest.approx(was) and number["value"] == pytest.approx(now)
    assert number["low"] < number["value"] and number["high"] is None
    assert words in told["sentence"] and told["sentence"].endswith("when it was healthy")


def test_a_law_is_told_as_it_is():
    entry = _entry("unknown_law", "joint", "shaft", "c", 0.1, "N m")
    assert changed_entry(nominal("one"), entry, _baseline()) == entry


@pytest.mark.parametrize("error", [1.1, 5.0])
def test_what_nobody_explained_of_the_healthy_robot_counts_as_noise(error):
    time = np.arange(300) / 100
    arrays = [values[:, None] for values in (np.sin(time), np.sin(time) + 0.05, np.sin(time) + 0.05)]
    prediction = Prediction("a.csv", "test", time, np.zeros(300), ("angle",), *arrays)
    findings = {"side": None, "verdict": "unexplained", "what": [], "data": []}
    selection = SimpleNamespace(nominal=SimpleNamespace(error=error), corrected=SimpleNamespace(error=error))
    arguments = {"changes": (), "finer": 2, "predictions": (prediction,), "findings": findings}
    healthy: Any = SimpleNamespace(**arguments, selection=selection)
    found = baseline_of(healthy)
    assert found.finer == 1
    assert found.discrepancy == ({"angle": pytest.approx(0.05, rel=0.03)} if error > 2.0 else {})


def _changed(now: Plant) -> Any:
    healthy, later = case_of("one", WELL, 31, trains=2), case_of("one", now, 32, trains=2)
    return finished(explain_change(healthy, later, CONFIG, {}))


@pytest.mark.slow
def test_the_change_alone_is_told():
    found = _changed(NOW)
    assert {entry["effect"] for entry in found.findings["baseline"]} == {"coulomb_friction", "command_delay"}
    [entry] = found.findings["what"]
    assert (entry["effect"], entry["name"]) == ("coulomb_friction", "shaft")
    number = entry["parameters"]["T"]
    assert number["from"] == pytest.approx(0.06, rel=0.15) and number["value"] == pytest.approx(0.16, rel=0.1)
    assert number["low"] <= number["value"] <= number["high"]
    assert [entry["role"] for entry in found.findings["data"]] == ["healthy"] * 3 + ["train"] * 2 + ["test"]
    assert "command_delay" in {change.effect for change in found.changes}  # the simulator has it all
    assert {"command_delay", "coulomb_friction"} <= {change.effect for change in found.native.changes}
    assert found.findings["fit"]["mjcf"]["test"] < 0.5 * found.findings["fit"]["nominal"]["test"]


@pytest.mark.slow
def test_what_was_wrong_already_is_no_news():
    found = _changed(replace(WELL))
    assert found.findings["verdict"] == "consistent" and found.findings["what"] == []
    assert {entry["effect"] for entry in found.findings["baseline"]} == {"coulomb_friction", "command_delay"}
