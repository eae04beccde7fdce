"""The record, files, figures and page of a run, from a made-up state."""

import io
import json

import numpy as np
import pyarrow.parquet
import pytest

from estexp_jax.package_data import model_path
from estexp_jax.physics.changes import Change
from estexp_jax.physics.interface import interface_of
from estexp_jax.physics.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.state import Row, RunState
from estexp_jax.recovery.trial import Trial
from estexp_jax.report.recover_files import record, write_history, write_traces
from estexp_jax.report.recover_page import headline, page
from estexp_jax.report.recover_run import RecoverTable, recover

WEAK = Change("motor_weakness", "knee_f", {"loss": 0.48})


def trial(distance: float) -> Trial:
    way = np.linspace(0.0, distance, 30)
    position = np.stack([way, 0.1 * way**2, np.full(30, 0.2)], axis=1)
    return Trial(np.arange(30) * 0.01, np.zeros((30, 8)), np.ones((30, 8)), position)


@pytest.fixture
def state() -> RunState:
    rows = [Row(n, p, g, 0.5 * g + n, 0.1, 1) for n, p in ((0, "exploration"), (1, "exploration")) for g in (1, 2, 3)]
    return RunState(
        phase="done",
        number=1,
        controllers=(np.zeros(68), np.ones(68)),
        simulated=(2.0, 1.8),
        diagnoses=((WEAK,),),
        residuals=(0.01,),
        probabilities=(0.9,),
        before=trial(2.0),
        trials=(trial(0.4), trial(1.7)),
        history=tuple(rows),
    )


def test_record_has_the_keys_of_run_json(state: RunState) -> None:
    written = record(state, "x", [WEAK], Settings().to_json())
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
    html = page("<run>", [WEAK], state, "x", {"seed": 0})
    assert "http" not in html.replace("http-equiv", "")
    assert "&lt;run&gt;" in html
    assert html.count("data:image/png;base64") == 2
    assert "knee_f lost 48 % of its strength" in html
    assert "2.00 m before" in headline(state, "x") and "1.70 m" in headline(state, "x")


def test_page_of_a_run_without_passes(state: RunState) -> None:
    young = RunState(before=trial(1.0), trials=(trial(0.2),), history=state.history[:3])
    assert "nothing was planted" in page("run", [], young, "x", {})


def test_table_prints_itself() -> None:
    row = {"number": 1, "diagnosis": ["a <b>"], "probability": "", "simulated": "1.00", "hardware": "0.90"}
    table = RecoverTable("title", [row])
    assert "a <b>" in str(table) and "a &lt;b&gt;" in table._repr_html_()


def test_a_run_can_be_looked_at_before_it_has_begun() -> None:
    run = recover(Robot.from_xml(model_path("quadruped")), quick=True, situation=5, seed=2, passes=2)
    assert run.job.settings.population == 64 and run.job.settings.passes == 2
    assert "not been damaged" in run._repr_html_()
