"""Recordings whose clocks do not agree: that is told first, and no physics is probable beside it."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.discovery.clock_doubt import clock_lines, clocks_doubted
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.inputs import read_inputs
from estexp_jax.recordings.write import write_csv

MODEL = """<mujoco><worldbody><body><joint name="elbow" damping="1" armature=".1"/><geom size=".05"/></body>
</worldbody><actuator><position name="servo" joint="elbow" kp="40"/></actuator>
<sensor><jointpos name="angle" joint="elbow"/></sensor></mujoco>"""
FINDINGS = {
    "what": [{"sentence": "the elbow rubs", "probability": 0.97}, {"sentence": "it is heavy", "probability": 0.2}],
    "alternatives": [{"effects": [], "probability": 0.8}],
    "advice": ["Record more."],
}


def _recording(*faults):
    time, column = np.arange(3.0), np.zeros((3, 1))
    return Recording("a.csv", time, column, column, column, column, column, clock_faults=faults)


def test_claims_of_sound_clocks_stay():
    assert clocks_doubted(FINDINGS, [_recording()]) == FINDINGS and clock_lines([_recording()]) == []


def test_wrong_clocks_come_first_and_lower_what_is_claimed():
    found = clocks_doubted(FINDINGS, [_recording(), replace(_recording("sensor.angle: is early"), name="b.csv")])
    assert [entry["probability"] for entry in found["what"]] == [0.5, 0.2]
    assert all(entry["sentence"].endswith("if the clocks are not to blame") for entry in found["what"])
    assert found["alternatives"][0]["probability"] == 0.5
    assert found["advice"] == ["The clocks of b.csv do not agree: sensor.angle: is early.", "Record more."]


@pytest.mark.parametrize(
    ("early", "rate", "told"), [(0.04, 1.0, "before its command"), (0.0, 1.006, "runs fast"), (-0.03, 1.0, "")]
)
def test_recordings_carry_what_their_clocks_lack(tmp_path, early, rate, told):
    (tmp_path / "arm.xml").write_text(MODEL)
    assert Robot.from_xml(tmp_path / "arm.xml").model.nu == 1
    time = np.arange(0.0, 40.0, 0.01)

    def motion(t):
        return np.sin(2 * t) + 0.5 * np.sin(0.7 * t)

    columns = {"time": time, "ctrl.servo": motion(time), "sensor.angle": 0.95 * motion(time / rate + early)}
    write_csv(tmp_path / "a.csv", columns)
    [recording] = read_inputs([str(tmp_path / "arm.xml"), str(tmp_path / "a.csv")]).recordings
    assert bool(recording.clock_faults) == bool(told)
    assert all(told in line for line in recording.clock_faults)
