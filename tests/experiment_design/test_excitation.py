"""Excitations begin at home, keep to their ranges and are those of their seed."""

import numpy as np
import pytest

from estexp_jax.experiment_design.excitation import (
    Wave,
    excitation_range,
    multisine,
    ramp_and_hold,
    ramps,
    random_levels,
    random_steps,
    sines,
)
from estexp_jax.physics.model.robot import Robot

ARM = """
<mujoco><worldbody><body><joint name="a" range="-1 1"/><geom size=".1"/>
  <body><joint name="b"/><geom size=".1"/></body></body></worldbody>
  <actuator><position joint="a" kp="5" ctrlrange="-0.4 1"/><motor joint="b" forcerange="-3 3" gear="2"/></actuator>
  <keyframe><key name="home" qpos="0.2 0"/></keyframe></mujoco>
"""
TIME = np.arange(600) / 100.0


@pytest.fixture(scope="module")
def arm() -> Robot:
    return Robot.from_string(ARM, "arm.xml")


@pytest.mark.parametrize("wave", [sines, random_levels, ramps, ramp_and_hold])
def test_waves_begin_at_zero_and_stay_within_one(wave: Wave) -> None:
    for seed in range(8):
        signal = wave(TIME, np.random.default_rng(seed))
        assert signal.shape == TIME.shape and signal[0] == pytest.approx(0.0, abs=1e-12)
        assert 0.01 < np.abs(signal).max() <= 1.0 + 1e-12


def test_servos_move_about_home_within_their_range_and_motors_up_to_their_force(arm: Robot) -> None:
    centre, reach = excitation_range(arm)
    np.testing.assert_allclose(centre, [0.2, 0.0])
    np.testing.assert_allclose(reach, [0.6, 3.0])


@pytest.mark.parametrize("excitation", [multisine, random_steps])
def test_commands_keep_to_a_share_of_the_range_and_to_their_seed(arm: Robot, excitation) -> None:
    centre, reach = excitation_range(arm)
    commands = excitation(arm, TIME, 0.5, 3)
    assert commands.shape == (600, 2) and np.all(np.abs(commands - centre) <= 0.5 * reach + 1e-12)
    np.testing.assert_allclose(commands[0], centre, atol=1e-12)
    np.testing.assert_array_equal(commands, excitation(arm, TIME, 0.5, 3))
    assert np.abs(commands - excitation(arm, TIME, 0.5, 4)).max() > 0.1
