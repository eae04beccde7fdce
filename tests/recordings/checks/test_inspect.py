"""What `check` says of a recording."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.checks.inspect import judge
from tests.recordings.checks.bad_logs import STEP, assert_found, assert_found_in_real, check, servo_log, without_motion


@pytest.fixture
def make(pendulum):
    """A 100 Hz recording of the pendulum with a gap of 50 ms; arrays may be replaced."""

    def build(**changes):
        time = np.arange(101) * 0.01
        time[61:] += 0.04
        sensor = np.full((101, 5), np.nan)
        sensor[:, 0] = 0.3 * np.sin(5 * time)
        ctrl, enable, nothing = np.zeros((101, 2)), np.ones((101, 2)), np.full((101, 2), np.nan)
        return replace(Recording("log.csv", time, ctrl, enable, sensor, nothing, nothing), **changes)

    return build


def test_clock_and_gaps(pendulum, make):
    clock = judge(pendulum, make())["clock"]
    assert clock["hz"] == pytest.approx(100.0)
    assert clock["jitter_s"] == pytest.approx(0.0, abs=1e-9)
    assert (clock["gaps"], clock["longest_s"]) == (1, pytest.approx(0.05))
    assert clock["gap_list"] == [{"time_s": pytest.approx(0.6), "length_s": pytest.approx(0.05)}]


def test_saturation_and_switches(pendulum, make):
    ctrl, enable = np.zeros((101, 2)), np.ones((101, 2))
    ctrl[:25, 0], ctrl[25:50, 0], enable[50:, 1] = 1.0, -2.0, 0.0
    commands = judge(pendulum, make(ctrl=ctrl, enable=enable))["commands"]
    assert commands["servo.1"]["saturated"] == pytest.approx(50 / 101)
    assert (commands["servo.1"]["low"], commands["servo.1"]["high"], commands["servo.1"]["changes"]) == (-2.0, 1.0, 2)
    assert commands["actuator_1"]["saturated"] is None  # it has no ctrlrange
    assert commands["actuator_1"]["enabled"] == pytest.approx(50 / 101)


def test_excitation(pendulum, make):
    joints = judge(pendulum, make())["joints"]
    assert joints["hinge"]["excited"] is True and joints["hinge"]["columns"] == ["sensor.angle"]
    assert joints["joint_1"] == {"columns": [], "span": None, "excited": None, "tells": {}}
    still = make(sensor=np.full((101, 5), 0.5), qpos=np.full((101, 2), 0.5))
    judged = judge(pendulum, still)
    assert judged["joints"]["hinge"]["columns"] == ["sensor.angle", "sensor.sensor_1", "qpos.hinge"]
    assert judged["joints"]["hinge"]["excited"] is False and judged["joints"]["joint_1"]["excited"] is False
    assert "hinge: does not move in this recording" in judged["suspicions"]


def test_suspicious_units(pendulum, make):
    good = judge(pendulum, make())["suspicions"]
    assert not any("degrees" in sentence or "another unit" in sentence for sentence in good)
    recording = make()
    ctrl = np.zeros((101, 2))
    ctrl[3, 0] = 90.0
    degrees = make(sensor=np.degrees(recording.sensor), ctrl=ctrl, time=1000 * recording.time)
    found = "\n".join(judge(pendulum, degrees)["suspicions"])
    assert "sensor.angle: reaches 17.1" in found
    assert "ctrl.servo.1: commands up to 90 rad" in found
    assert "time: rows are 10 s apart" in found


def test_the_judgement_is_json_without_nan(pendulum, make):
    judged = json.loads(json.dumps(judge(pendulum, make()), allow_nan=False))
    assert (judged["rows"], judged["role"]) == (101, "train")
    assert judged["readings"]["sensor.acc.0"] == {"samples": 0, "low": None, "high": None, "step": None}
    assert judged["readings"]["sensor.angle"]["samples"] == 101


def test_a_good_recording_has_no_faults(arm, tmp_path):
    result = check(servo_log(), tmp_path, arm)
    assert result["faults"] == [] and result["notes"] == []
    assert result["commands"]["servo"]["lag_s"] == pytest.approx(0.03, abs=0.006)
    assert result["readings"]["sensor.angle"]["step"] == pytest.approx(STEP)


STILL = (without_motion, "still", "does not move")


def test_a_joint_that_never_moves_is_found(arm, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_found(STILL, arm, Path())


def test_a_joint_that_never_moves_is_found_in_real_recordings(real_data, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_found_in_real(STILL, real_data, Path())
