"""Sensors and units of channels."""

import pytest

from estexp_jax.report.channels import sensor_of, unit_of

XML = """<mujoco><worldbody><body><joint name="hinge"/><geom size=".1"/><site name="s"/>
<body><joint name="slide" type="slide"/><geom size=".1"/></body></body></worldbody>
<actuator><motor name="m" joint="slide"/><motor name="n" site="s"/></actuator>
<sensor><jointpos name="angle" joint="hinge"/><accelerometer name="acc" site="s"/><jointvel name="rate" joint="slide"/>
<actuatorfrc name="force" actuator="m"/><actuatorfrc name="thrust" actuator="n"/><magnetometer name="mag" site="s"/>
</sensor></mujoco>"""


@pytest.fixture(scope="module")
def robot():
    from estexp_jax.physics.model.robot import Robot

    return Robot.from_string(XML)


@pytest.mark.parametrize(
    ("channel", "unit"),
    [
        ("angle", "rad"),
        ("acc.1", "m/s^2"),
        ("rate", "m/s"),
        ("force", "N"),
        ("thrust", ""),
        ("mag.0", ""),
        ("qpos.hinge", "rad"),
        ("qpos.slide", "m"),
    ],
)
def test_units_follow_sensor_and_joint(robot, channel, unit):
    assert unit_of(robot, channel) == unit


def test_each_value_of_a_sensor_belongs_to_it(robot):
    names = ["angle", "acc.0", "acc.1", "acc.2", "rate", "force"]
    assert [sensor_of(robot, name) for name in names] == [0, 1, 1, 1, 2, 3]
