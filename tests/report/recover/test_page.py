"""The record, files, figures and page of a run, from a made-up state."""

import io
import json
from dataclasses import replace

import numpy as np
import pyarrow.parquet
import pytest

from estexp_jax.package_data import model_path
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.state import RunState
from estexp_jax.report.recover.figure import _captions, path_figure
from estexp_jax.report.recover.files import run_record, write_history, write_traces
from estexp_jax.report.recover.page import recover_advice, recover_headline, recover_page, recover_verdict
from estexp_jax.report.recover.run import RecoverTable, recover_run
from estexp_jax.runs.files import json_plain
from tests.report.examples import LOST, WEAK, recovered, trial


@pytest.fixture
def state() -> RunState:
    return recovered()


def test_record_has_the_keys_of_run_json(state: RunState) -> None:
    written = run_record(state, "x", [WEAK], Settings().to_json())
    assert list(written) == ["config", "seed", "planted", "distance", "passes"]
    assert written["distance"] == {"before": pytest.approx(2.0), "damaged": pytest.approx(0.4)}
    (one,) = written["passes"]
    assert list(one) == ["simulated_m", "diagnosis", "probability", "rivals", "alarm", "hardware_m"]
    assert one["diagnosis"] == [
        {"effect": "motor_weakness", "kind": "actuator", "name": "knee_f", "parameters": {"loss": 0.48}}
    ]
    json.dumps(written)


def test_history_has_one_row_a_generation(state: RunState) -> None:
    stream = io.BytesIO()
    write_history(stream, state)
    table = pyarrow.parquet.read_table(stream)
    assert table.column_names == ["pass", "phase", "generation", "best", "median", "dominant"]
    assert table.num_rows == 6


def test_traces_are_named_by_sensor_and_actuator(state: RunState) -> None:
    robot, stream = Robot.from_xml(model_path("quadruped")), io.BytesIO()
    write_traces(stream, state, robot, interface_of(robot))
    stream.seek(0)
    with np.load(stream) as arrays:
        assert len(arrays.files) == 2 * (1 + 8 + 8)
        assert {"trial_0/time", "trial_1/touch_f", "trial_1/ctrl/knee_r"} <= set(arrays.files)
        assert np.all(arrays["trial_1/ctrl/knee_r"] == 1.0)


def test_page_stands_alone_and_tells_the_story(state: RunState) -> None:
    html = recover_page("<run>", [WEAK], state, "x", {"seed": 0})
    assert "http" not in html.replace("http-equiv", "")
    assert "&lt;run&gt;" in html
    assert html.count("data:image/svg+xml;base64") == 2
    assert "knee_f lost 48 % of its strength" in html
    assert "2.00 m before" in recover_headline(state, "x") and "1.70 m" in recover_headline(state, "x")


def test_the_verdict_is_what_the_last_trial_won_back(state: RunState) -> None:
    for distance, told in ((1.9, "walks again."), (1.3, "in part"), (0.5, "has not recovered")):
        assert told in recover_verdict(replace(state, trials=(trial(0.4), trial(distance))), "x")
    assert "cost the robot nothing" in recover_verdict(replace(state, before=trial(0.3)), "x")
    assert recover_verdict(replace(state, trials=(trial(0.4),)), "x") == "The robot is damaged."
    assert "not been damaged" in recover_verdict(RunState(), "x")


def test_advice_follows_from_alarm_rivals_and_what_was_foretold(state: RunState) -> None:
    assert recover_advice(state, "x") == []
    doubtful = replace(state, alarms=(True,), alternatives=((((LOST,), 0.2),),), simulated=(2.0, 0.6))
    told = " ".join(recover_advice(doubtful, "x"))
    assert "--model-error" in told and "55 %" in told and "--passes" in told
    html = recover_page("run", [LOST], doubtful, "x", {})
    assert "do not trust" in html and "20 %" in html and "upper_&lt;b&gt;f" in html and "<b>f" not in html
    lame = replace(state, trials=(trial(0.4), trial(0.5)), simulated=(2.0, 0.5))
    assert "--generations" in " ".join(recover_advice(lame, "x"))


def test_captions_say_once_what_stays() -> None:
    captions = _captions(((WEAK,), (WEAK,), ()), 17)
    assert captions == ["1:\nthe motor knee_f\nlost 48 % of its\nstrength", "2: as before", "3:\nnothing differs"]
    assert _captions(((WEAK,), ()), 5) == ["1", "2"]


@pytest.mark.parametrize("stands_in", [False, True])
def test_the_legend_of_the_ways_is_inside_the_picture(state: RunState, stands_in: bool) -> None:
    far = [replace(t, position=100.0 * t.position) for t in state.trials]
    figure = path_figure(replace(state, before=far[1], trials=far), "x", stands_in=stands_in)
    figure.savefig(io.BytesIO(), dpi=100)
    (legend,) = figure.legends
    assert len(legend.get_texts()) == 3
    box = legend.get_window_extent()
    assert box.x0 >= 0.0 and box.x1 <= figure.bbox.x1


def test_page_of_a_run_without_passes(state: RunState) -> None:
    young = RunState(before=trial(1.0), trials=(trial(0.2),), history=state.history[:3])
    assert "nothing was planted" in recover_page("run", [], young, "x", {})


def test_table_prints_itself() -> None:
    row = {"number": 1, "diagnosis": ["a <b>"], "probability": "", "simulated": "1.00", "hardware": "0.90"}
    table = RecoverTable("title", [row])
    assert "a <b>" in str(table) and "a &lt;b&gt;" in table._repr_html_()


def test_a_run_can_be_looked_at_before_it_has_begun() -> None:
    run = recover_run(Robot.from_xml(model_path("quadruped")), quick=True, situation=5, seed=2, passes=2)
    assert run.job.settings.population == 64 and run.job.settings.passes == 2
    assert "not been damaged" in run._repr_html_()


def test_a_robot_of_the_users_may_come_an_unknown_way(state: RunState) -> None:
    unseen = replace(trial(0.0), position=np.full((30, 3), np.nan))
    measured, state = state, replace(state, trials=(unseen, unseen))
    assert recover_verdict(state, "x") == "How far the robot walks is not known."
    told = recover_headline(state, "x", stands_in=True)
    assert told.startswith("The undamaged simulator walked 2.00 m, the damaged robot an unknown distance;")
    html = recover_page("run", None, state, "x", {}, stands_in=True)
    assert "really done" not in html and "the undamaged simulator" in html and "nan m" not in html
    assert "seen from above" not in html and "seen from above" in recover_page("run", None, measured, "x", {})
    assert recover_advice(state, "x") == []
    written = json_plain(run_record(state, "x", [], Settings().to_json(), stands_in=True))
    assert written["distance"] == {"before": None, "damaged": None} and written["passes"][0]["hardware_m"] is None
