"""What acts on a slide is told in metres and newtons."""

import mujoco
import pytest

from estexp_jax.physics.effects.units import on_slide, unit_at
from estexp_jax.physics.model.robot import Robot

CART = """
<mujoco>
  <worldbody><body><joint name="rail" type="slide" axis="1 0 0"/><geom size="0.1"/>
    <body><joint name="pivot" axis="0 1 0"/><geom size="0.05" pos="0 0 0.3"/></body></body></worldbody>
  <actuator><motor name="push" joint="rail"/><motor name="turn" joint="pivot"/></actuator>
</mujoco>
"""


@pytest.mark.parametrize(
    ("hinge", "slide"),
    [
        ("stops at -0.5 rad and at 0.187 rad", "stops at -0.5 m and at 0.187 m"),
        ("with 0.2 N m for each rad/s of speed", "with 0.2 N for each m/s of speed"),
        ("A spring of 3 N m/rad pulls", "A spring of 3 N/m pulls"),
        ("0.1 kg m2 of rotor inertia", "0.1 kg of rotor inertia"),
        ("the joint radius moves 2 ms late", "the joint radius moves 2 ms late"),
    ],
)
def test_units_of_a_slide_take_the_place_of_a_hinges(hinge, slide):
    assert on_slide(hinge) == slide


def test_only_what_acts_on_a_slide_is_told_so():
    robot = Robot.from_string(CART, "cart.xml")
    assert [unit_at(robot, "joint", name, "N m") for name in ("rail", "pivot", "*")] == ["N", "N m", "N m"]
    assert [unit_at(robot, "actuator", name, "rad/s") for name in ("push", "turn")] == ["m/s", "rad/s"]
    assert unit_at(robot, "environment", None, "rad") == "rad"
    assert robot.model.jnt_type[0] == mujoco.mjtJoint.mjJNT_SLIDE
