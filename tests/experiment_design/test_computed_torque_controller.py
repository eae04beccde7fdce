"""Torque motors move their joints as planned, whatever the robot is: falling arms show little."""

from __future__ import annotations

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.experiment_design.computed_torque_controller import controlled_commands, torque_motors
from estexp_jax.experiment_design.excitation import multisine
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.replay.explained_simulator import ExplainedSimulator

UPRIGHT = """
<mujoco model="upright"><compiler angle="radian" autolimits="true"/><option timestep="0.004"/><worldbody>
  <body name="lower"><joint name="foot" axis="0 1 0" range="-0.4 2"/>
    <geom type="capsule" fromto="0 0 0 0 0 0.4" size="0.02" mass="1"/>
    <body name="upper" pos="0 0 0.4"><joint name="waist" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 0.3" size="0.02" mass="0.5"/>
      <body name="hand" pos="0 0 0.3"><joint name="lift" type="slide" axis="0 0 1" range="0 0.1"/>
        <geom size="0.03" mass="0.2"/></body></body></body></worldbody>
  <actuator><motor name="low" joint="foot" gear="20" ctrlrange="-1 1"/><motor name="high" joint="waist" gear="-1"/>
    <position name="servo" joint="lift" kp="200" kv="10"/></actuator>
</mujoco>
"""
PERIOD, ROWS = 0.01, 400


@pytest.fixture(scope="module")
def upright() -> Robot:
    return Robot.from_string(UPRIGHT, "upright.xml")


@pytest.mark.parametrize("differs", ["", "coulomb_friction@foot T=0.4", "command_delay@high delay=0.02"])
def test_an_upright_arm_moves_as_planned_and_its_commands_do_the_same_again(upright: Robot, differs: str) -> None:
    motors, time = torque_motors(upright), PERIOD * np.arange(ROWS)
    assert motors == (0, 1)
    holder = controlled_commands(upright, motors, multisine(upright, time, 0.6, 41), PERIOD)
    real = ExplainedSimulator(upright, tuple(parse_change(text, upright) for text in [differs] if text))
    traces, commands = real.steered(holder, ROWS, period=PERIOD)
    low, high = upright.model.jnt_range[0]
    assert traces.qpos[:, 0].min() > low and traces.qpos[:, 0].max() < high
    assert np.ptp(traces.qpos[:, :2], axis=0).min() > 0.3
    error = np.abs(traces.qpos[:, :2] - holder.planned)[ROWS // 4 :].max()
    assert error < (0.1 if differs else 0.02)
    assert np.abs(commands[:, 0]).max() < 1.0, "within its range, not at its ends"
    again = real.rollout(commands, period=PERIOD)
    np.testing.assert_allclose(again.qpos[: ROWS // 4], traces.qpos[: ROWS // 4], atol=1e-3)
    np.testing.assert_allclose(again.qvel[1], traces.qvel[1], rtol=1e-4, atol=1e-6)


def test_one_row_is_no_motion(upright: Robot) -> None:
    with pytest.raises(InputError, match="1 rows are no motion"):
        ExplainedSimulator(upright, ()).steered(lambda *_: np.zeros(3), 1)


def test_who_is_held() -> None:
    both = UPRIGHT.replace("<position", '<motor name="other" joint="waist"/><position')
    assert torque_motors(Robot.from_string(both)) == (0,), "two drive the waist"
    loose = UPRIGHT.replace('<body name="lower">', '<body name="lower"><freejoint/>').replace(
        '<joint name="foot" axis="0 1 0" range="-0.4 2"/>', ""
    )
    loose = loose.replace('<motor name="low" joint="foot" gear="20" ctrlrange="-1 1"/>', "")
    assert torque_motors(Robot.from_string(loose)) == (), "a floating base"
    servos = UPRIGHT.replace("<motor", "<position").replace(' ctrlrange="-1 1"', "")
    assert torque_motors(Robot.from_string(servos)) == ()
