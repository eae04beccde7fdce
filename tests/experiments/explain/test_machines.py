"""Cases from logs like the published ones: what is written, what is withheld, how it is scored."""

import pickle

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.registry import effect
from estexp_jax.recordings.inputs import read_inputs
from experiments.benchmark.scoring.judge import judge
from experiments.explain.machines import cases, page
from experiments.explain.machines import run as front
from experiments.explain.machines.devices import DEVICES, settings
from experiments.explain.machines.score import agreement, answer_of, score
from experiments.explain.machines.withheld import WITHHELD

XML = """
<mujoco><compiler angle="radian"/><worldbody><body name="arm"><joint name="shaft" axis="0 -1 0"/>
<inertial pos="0 0 -0.1" mass="0.49" diaginertia="1e-4 1e-4 1e-4"/></body></worldbody>
<actuator><position name="servo" joint="shaft" kp="0.2217"/></actuator>
<sensor><jointpos name="angle" joint="shaft"/></sensor></mujoco>
"""
FILES = [f"kp{g}_{m}.csv" for g in (100, 200, 800) for m in ("sin_sin", "up_and_down")]


@pytest.fixture
def data(tmp_path):
    """A folder as the data's, with logs of two files a gain."""
    folder = tmp_path / "data" / "xl330"
    folder.mkdir(parents=True)
    (folder / "nominal.xml").write_text(XML)
    time = np.arange(0.0, 5.0, 0.01)
    log = {
        "timestamp": time,
        "goal_position": np.sin(time),
        "position": np.sin(time - 0.1),
        "torque_enable": time * 0 + 1,
    }
    for name in FILES:
        cases.write_log(folder / name, log | {"input_volts": time * 0 + 7.4})
    return tmp_path / "data"


def _case(data, name, quick=False):
    return cases.cases(data, quick)[name]


def test_cases_are_read_by_the_program_with_their_settings(data, tmp_path):
    cases.write(_case(data, "xl330-kp800", quick=True), data, tmp_path / "case")
    inputs = read_inputs([str(tmp_path / "case" / "recordings.toml")], test=[], maps=[])
    assert [r.role for r in inputs.recordings] == ["train"] * 4 + ["test"] * 2
    assert inputs.recordings[0].settings["actuator.servo.kp"] == pytest.approx(0.2217)
    assert inputs.recordings[-1].settings["actuator.servo.kp"] == pytest.approx(8 * 0.2217)
    assert inputs.recordings[0].time[-1] == pytest.approx(DEVICES["xl330"].piece, abs=0.011)


def test_halves_are_disjoint_and_share_the_test(data):
    whole, *halves = (_case(data, f"xl330-kp800{end}") for end in ("", "-half0", "-half1"))
    assert not set(halves[0].train) & set(halves[1].train)
    assert sorted([*halves[0].train, *halves[1].train]) == sorted(whole.train)
    assert all(h.test == whole.test and not set(h.test) & set(h.train) for h in halves)


def test_a_command_logged_early_is_a_robot_that_obeys_late(data, tmp_path):
    cases.write(_case(data, "xl330-late-command"), data, tmp_path / "case")
    recording = read_inputs([str(tmp_path / "case" / "recordings.toml")], test=[], maps=[]).recordings[0]
    middle = recording.time < 4.85
    np.testing.assert_allclose(recording.ctrl[middle, 0], np.sin(recording.time[middle] + 0.06), atol=1e-4)


def test_the_program_is_given_what_is_not_so(data, tmp_path):
    for name in ("xl330-light-load", "xl330-stiff-servo"):
        cases.write(_case(data, name), data, tmp_path / name)
    assert 'mass="0.15"' in (tmp_path / "xl330-light-load" / "nominal.xml").read_text()
    inputs = read_inputs([str(tmp_path / "xl330-stiff-servo" / "recordings.toml")], test=[], maps=[])
    assert inputs.recordings[0].settings["actuator.servo.kp"] == pytest.approx(4 * 0.2217)
    assert settings(DEVICES["so101"], "chirp.csv", {}) == {}


def _findings(*claims):
    what = [{"effect": e, "kind": effect(e).kind, "name": n, "parameters": {p: {"value": v}}} for e, n, p, v in claims]
    return {"verdict": "missing_physics", "what": what}


def test_a_withheld_truth_is_scored_beside_what_was_there_before():
    late = next(w for w in WITHHELD if w.name == "xl330-late-command")
    base = _findings(("command_delay", "servo", "delay", 0.01))
    found = score(late, _findings(("command_delay", "*", "delay", 0.076)), base)
    assert found["found"] and found["error"] == pytest.approx(0.1)
    found = score(late, _findings(("sensor_delay", "angle", "delay", 0.06)), base)
    assert (found["found"], found["as"], found["error"]) == (True, "sensor_delay@angle", pytest.approx(0.0))
    assert not score(late, _findings(), base)["found"]
    weak = next(w for w in WITHHELD if w.name == "xl330-stiff-servo")
    found = score(
        weak, _findings(("motor_weakness", "servo", "loss", 0.8)), _findings(("motor_weakness", "servo", "loss", 0.2))
    )
    assert found["error"] == pytest.approx(0.0) and found["named_first"]


def test_of_several_motors_the_one_withheld_must_be_named():
    weak = next(w for w in WITHHELD if w.name == "pendulum-weak-motor")
    assert not score(weak, _findings(("motor_weakness", "*", "loss", 0.7)), None)["found"]
    assert score(weak, _findings(("motor_weakness", "elbow", "loss", 0.7)), None)["found"]


def test_coarser_encoders_must_change_no_claim():
    coarse = next(w for w in WITHHELD if w.truth is None)
    one = _findings(("armature", "shaft", "I", 0.1))
    assert score(coarse, one, one)["found"]
    assert not score(coarse, {"verdict": "unexplained", "what": []}, one)["found"]


def test_agreement_is_the_share_both_name():
    one = _findings(("armature", "shaft", "I", 0.1), ("back_emf", "servo", "k", 0.1))
    assert agreement(one, _findings(("armature", "shaft", "I", 0.3))) == 0.5
    assert agreement(_findings(), _findings()) is None


def test_without_data_it_says_where_to_get_them(monkeypatch, tmp_path):
    monkeypatch.setenv("ESTEXP_DATA", str(tmp_path / "nowhere"))
    with pytest.raises(InputError, match=r"github\.com/Rhoban/bam"):
        front.main(["--quick", "--out", str(tmp_path / "out")])


def test_the_page_tells_what_has_not_run(data, tmp_path, monkeypatch):
    monkeypatch.setenv("ESTEXP_DATA", str(data))
    text = page.write_page(tmp_path, [], 0).read_text()
    assert "not run" in text and "0 of 0 found" in text and "cannot show" in text
    assert (tmp_path / "summary.json").is_file()


def test_cases_travel_to_workers_and_are_written_once(data, tmp_path, monkeypatch):
    monkeypatch.setenv("ESTEXP_DATA", str(data))
    planned = cases.planned(1, "quick")
    assert pickle.dumps(planned), "workers are other processes"
    answer = cases.write_case(tmp_path, "xl330-late-command", planned["xl330-late-command"])
    manifest = tmp_path / "cases" / "xl330-late-command" / "recordings.toml"
    manifest.write_text("mine")
    assert cases.write_case(tmp_path, "xl330-late-command", planned["xl330-late-command"]) == answer
    assert manifest.read_text() == "mine" and answer["effects"][0]["effect"] == "command_delay"


def test_the_judge_of_all_sets_judges_a_case():
    fit = {name: {"train": 0.1, "test": 0.1} for name in ("nominal", "explained", "noise_floor")}
    more = {"where": [], "fit": fit | {"gain": {"value": 0.5}}, "cost": {"robot_steps": 7}}
    claim = _findings(("command_delay", "servo", "delay", 0.06)) | more
    claim["what"][0]["probability"] = 0.9
    late = next(w for w in WITHHELD if w.name == "xl330-late-command")
    right = judge(late.name, answer_of(late, late.device), claim | {"when": {"onset_s": {}}})
    assert (right.group, right.named_all, right.name_first, right.sizes[0].true) == ("withheld", True, True, 0.06)
    other = judge(late.name, answer_of(None, late.device), claim)
    assert (other.group, other.named_all, other.gain) == ("recorded", None, 0.5)


def test_every_withheld_truth_fits_the_published_models(real_data):
    for case in cases.cases(real_data, True).values():
        if case.withheld and case.withheld.model:
            assert case.withheld.model[0] in (real_data / case.device.name / "nominal.xml").read_text()
