"""Logs are put right before physics is looked for; their faults are told first, with what is found beside them."""

import json

import numpy as np
import pytest
from jsonschema import Draft202012Validator

from estexp_jax.discovery.diagnosis import Case, ExplainConfig
from estexp_jax.discovery.explain import explain
from estexp_jax.discovery.log_mending import mended
from estexp_jax.package_data import schema_path
from tests.estimation.two_links import arm, faulty, log_of

READINGS = "channels_exchanged@q_shoulder with=q_elbow"


def case(*faults, only=(0, 1, 2), real=None, fault_free_test=False):
    """Two training recordings and a test, with faults in some of them."""
    real = arm() if real is None else real
    logs = [log_of(real, k, role="test" if k == 2 else "train") for k in range(3)]
    spared = {2} if fault_free_test else set()
    wrong = [faulty(arm(), log, *faults) if k in only and k not in spared else log for k, log in enumerate(logs)]
    return Case(arm(), tuple(wrong), (arm(),) * 3)


def test_right_logs_stay_as_they_are():
    given = case()
    assert mended(given, ExplainConfig()) == (given, ())


def test_what_all_training_recordings_show_is_undone_in_the_test_too():
    right, [fault] = mended(case(READINGS), ExplainConfig())
    assert fault.everywhere and not fault.refuted and fault.probability > 0.99
    for log, wanted in zip(right.recordings, case().recordings, strict=True):
        np.testing.assert_array_equal(log.sensor, wanted.sensor)
        assert any("put right" in note for note in log.notes)


def test_one_recording_is_put_right_alone():
    right, [fault] = mended(case(READINGS, only=(1,)), ExplainConfig())
    assert not fault.everywhere and fault.recordings == ("train_1.csv",)
    for log, wanted in zip(right.recordings, case().recordings, strict=True):
        np.testing.assert_array_equal(log.sensor, wanted.sensor)


def test_a_test_that_does_not_show_it_lowers_what_is_told():
    _, [fault] = mended(case(READINGS, fault_free_test=True), ExplainConfig())
    assert fault.refuted


def test_no_fault_is_looked_for_that_was_not_asked_for():
    given = case(READINGS)
    assert mended(given, ExplainConfig(effects=("viscous_friction",))) == (given, ())


FRICTIONS = ("viscous_friction", "coulomb_friction")


def explained(given):
    steps = explain(given, ExplainConfig(effects=(*FRICTIONS, "channels_exchanged", "command_lead")))
    while True:
        try:
            next(steps)
        except StopIteration as end:
            return end.value.findings


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fault", "real", "rest"),
    [
        (READINGS, {}, []),
        (READINGS, {"friction": 0.1}, ["coulomb_friction"]),
        ("command_lead lead=0.024", {"friction": 0.1}, ["coulomb_friction"]),
    ],
)
def test_faults_of_logging_come_first_and_physics_after_them(fault, real, rest):
    found = explained(case(fault, real=arm(**real)))
    name = fault.partition("@")[0].partition(" ")[0]
    assert found["verdict"] == "missing_physics" and found["side"] == "sensor"
    assert found["what"][0]["effect"] == name and found["what"][0]["probability"] > 0.9
    assert [entry["effect"] for entry in found["what"][1:]][: len(rest)] == rest
    assert found["where"][0]["kind"] == "recording" and found["fit"]["gain"]["low"] > 0.5
    schema = json.loads(schema_path("findings").read_text(encoding="utf-8"))
    whole = json.loads(json.dumps({**found, "versions": {"estexp": "1"}}))
    wrong = [e for e in Draft202012Validator(schema).iter_errors(whole) if not {"cost", "versions"} & set(e.path)]
    assert wrong == []
