"""Edits as assignments keep to the user's own values: they add, scale or set as the effect does."""

import pytest

from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.engines.standalone.assignments import assignments
from tests.physics.exported import robot_of


@pytest.mark.parametrize(
    ("planted", "field", "name", "op", "value"),
    [
        ("viscous_friction@elbow c=0.1", "dof_damping", "elbow", "add", 0.1),
        ("motor_weakness@lift loss=0.3", "actuator_gainprm", "lift", "scale", 0.7),
        ("torque_saturation@lift limit=2", "actuator_forcerange", "lift", "set", 2.0),
        ("joint_limit@elbow low=0.2 high=0.6", "jnt_range", "elbow", "set", 0.6),
        ("joint_limit@elbow low=0.2 high=0.6", "jnt_limited", "elbow", "set", 1.0),
    ],
)
def test_an_edit_is_an_assignment(planted, field, name, op, value):
    robot = robot_of("servos")
    found = assignments(robot, [(parse_change(planted, robot), False)])
    assert {e.name for e in found} == {name}, "nothing else is touched"
    [last] = [e for e in found if e.field == field][-1:]
    assert (last.op, last.value) == (op, pytest.approx(value))
