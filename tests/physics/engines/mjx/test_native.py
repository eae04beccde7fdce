"""What MJX ignores or refuses of MuJoCo's elements is not written for it."""

import pytest

from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.effects.written import mjcf_refusal
from estexp_jax.physics.engines.mjx.native import mjx_refusal
from tests.physics.exported import robot_of


@pytest.mark.parametrize(
    ("planted", "why"),
    [
        ("coulomb_friction@elbow T=0.2", ""),
        ("body_mass@lower dm=0.1", ""),
        ("torque_saturation@lift limit=2", ""),
        ("command_delay@lift delay=0.02", "MJX ignores delays"),
        ("sensor_delay@bent delay=0.02", "MJX ignores delays"),
        ("quadratic_drag@elbow c=0.1", "MJX ignores damping of several powers"),
        ("cogging@elbow A=0.1 n=7 phase=0", "MJX has no DC motors"),
        ("dead_band@bend half_width=0.05", "MuJoCo has no element for it"),
    ],
)
def test_what_mjx_simulates_has_a_place(planted, why):
    robot = robot_of("servos")
    change = parse_change(planted, robot)
    assert mjx_refusal(robot, change) == why
    assert why.startswith("MuJoCo") or not mjcf_refusal(robot, change), "plain MuJoCo has it"
