"""The record, history and traces of a run."""

import io
import json

import numpy as np
import pyarrow.parquet
import pytest

from estexp_jax.package_data import model_path
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.state import RunState
from estexp_jax.report.recover.run_data import run_record, write_history, write_traces
from tests.report.examples import WEAK, recovered


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
