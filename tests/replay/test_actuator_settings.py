"""Settings of motors are those that their models have, at the joint."""

import pytest

from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.effects.written import written
from estexp_jax.physics.model.robot import Robot
from estexp_jax.replay.actuator_settings import actuator_settings_of
from tests.physics.exported import robot_of


def test_a_servos_settings():
    robot = robot_of("servos")
    texts = ("command_delay@lift delay=0.0251", "coulomb_friction@shoulder T=0.3", "viscous_friction@shoulder c=0.1")
    lift, bend = actuator_settings_of(Robot.from_spec(written(robot, [parse_change(t, robot) for t in texts])))
    assert (lift.name, lift.joint, lift.stiffness, lift.damping, lift.effort_limit) == ("lift", "shoulder", 20, 0.4, 6)
    assert (lift.armature, lift.frictionloss) == (0.005, 0.3) and lift.viscous_damping == pytest.approx(0.15)
    assert lift.delay == pytest.approx(0.0251) and (lift.delay_min_lag, lift.delay_max_lag) == (12, 13)
    assert bend.delay == bend.delay_min_lag == bend.delay_max_lag == 0


def test_a_motors_settings_are_at_the_joint():
    robot = robot_of("motors")
    texts = ("command_delay@push delay=0.012", "torque_saturation@push limit=4")
    push, turn = actuator_settings_of(Robot.from_spec(written(robot, [parse_change(t, robot) for t in texts])))
    assert (push.joint, push.stiffness, push.damping) == ("rail", 0.0, 0.0)
    assert push.effort_limit == pytest.approx(4.0) and turn.effort_limit is None
    assert push.delay == pytest.approx(0.012) and push.delay_min_lag == push.delay_max_lag == 3
