"""Guesses at what the columns of a log are, by their names."""

import pytest

from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.templates.manifest import guess

TWO = """
<mujoco><worldbody>
  <body><joint name="Pitch" axis="0 1 0"/><geom size="0.1"/>
    <body><joint name="Wrist_Pitch" axis="0 1 0"/><geom size="0.1"/></body></body>
</worldbody>
<actuator><position name="m1" joint="Pitch"/><position name="m2" joint="Wrist_Pitch"/></actuator>
<sensor><jointpos name="Pitch_pos" joint="Pitch"/><jointpos name="Wrist_Pitch_pos" joint="Wrist_Pitch"/>
<jointvel name="w1" joint="Pitch"/></sensor></mujoco>
"""


@pytest.mark.parametrize(
    ("names", "found"),
    [
        (
            ["timestamp_us", "command_Wrist_Pitch", "command_Pitch", "position_Pitch", "position_Wrist_Pitch"],
            {"time": "timestamp_us", "ctrl.m1": "command_Pitch", "ctrl.m2": "command_Wrist_Pitch"}
            | {"sensor.Pitch_pos": "position_Pitch", "sensor.Wrist_Pitch_pos": "position_Wrist_Pitch"},
        ),
        (["time", "goalPosition1", "goalPosition2"], {"ctrl.m1": "goalPosition1", "ctrl.m2": "goalPosition2"}),
        (["t", "cmd_a", "cmd_b", "cmd_c", "speed"], {"time": "t", "sensor.w1": "speed"}),
        (["ctrl.m1", "cmd_Pitch", "temperature"], {}),
        (["torque_enable_Pitch", "pos"], {"enable.m1": "torque_enable_Pitch"}),
    ],
)
def test_guesses(names, found):
    assert guess(Robot.from_string(TWO), names) == found
