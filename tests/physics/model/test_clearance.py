"""Contacts between a robot's own parts are left out only where recordings never brought these near each other."""

import numpy as np
import pytest

from estexp_jax.physics.engines.lanes.model import lanes_refusal
from estexp_jax.physics.engines.mjx.model import mjx_model
from estexp_jax.physics.model.clearance import without_collisions
from estexp_jax.physics.model.robot import Robot

LEGS = """
<mujoco>
  <worldbody>
    <geom name="floor" type="plane" size="5 5 0.1" pos="0 0 -2"/>
    <body name="left"><joint name="l" axis="0 1 0"/><geom name="lf" size="0.05" mass="1" pos="0 0 -0.5"/></body>
    <body name="right" pos="0.3 0 0"><joint name="r" axis="0 1 0"/><geom name="rf" size="0.05" mass="1" pos="0 0 -0.5"/>
    </body>
  </worldbody>
  <actuator><motor name="l" joint="l"/><motor name="r" joint="r"/></actuator>
</mujoco>
"""


def path(swing: float) -> np.ndarray:
    """Both legs swing towards each other and back."""
    angle = swing * np.sin(np.linspace(0.0, np.pi, 50))
    return np.stack([-angle, angle], axis=1)


@pytest.fixture(scope="module")
def robot() -> Robot:
    return Robot.from_string(LEGS, "legs.xml")


@pytest.mark.parametrize(("swing", "apart"), [(0.1, True), (0.17, True), (0.19, False), (0.3, False)])
def test_only_what_stayed_apart_is_left_out(robot: Robot, swing: float, apart: bool) -> None:
    pair = robot.index("body", "left"), robot.index("body", "right")
    assert (pair in without_collisions(robot, [path(0.05), path(swing)])) == apart


@pytest.mark.parametrize("shape", ['type="plane" size="5 5 .1"', 'type="box" size="5 5 .1"'])
@pytest.mark.parametrize(("height", "apart"), [(-0.7, True), (-0.56, True), (-0.54, False), (-0.4, False)])
def test_surroundings_are_left_out_where_a_bolted_robot_keeps_off_them(shape: str, height: float, apart: bool) -> None:
    top = height - 0.02 - (0.1 if "box" in shape else 0.0)
    xml = LEGS.replace('type="plane" size="5 5 0.1" pos="0 0 -2"', f'{shape} pos="0 0 {top}"')
    found = without_collisions(Robot.from_string(xml), [path(0.3)])  # they reach down to -0.55 m
    assert ((0, 1) in found, (0, 2) in found) == (apart, apart)


def test_what_floats_may_always_fall_on_its_surroundings() -> None:
    xml = LEGS.replace('<joint name="l" axis="0 1 0"/>', '<freejoint name="l"/>').replace(
        '<motor name="l" joint="l"/>', ""
    )
    at = np.array([[0.0, 0.0, 5.0, 1.0, 0.0, 0.0, 0.0, 0.0]])
    assert set(without_collisions(Robot.from_string(xml), [at])) == {(1, 2), (0, 2)}


def test_a_robot_without_them_is_the_same_but_for_them(robot: Robot) -> None:
    found = robot.without_contacts(without_collisions(robot, [path(0.1)]))
    assert found.model.nexclude == 3 and robot.model.nexclude == 0
    assert found.names("geom") == robot.names("geom")
    assert robot.without_contacts([]) is robot
    refused = lanes_refusal(mjx_model(robot, ()), frozenset())
    assert refused is not None and "'lf'" in refused
    assert lanes_refusal(mjx_model(found, ()), frozenset()) is None


TURNTABLE = """
<mujoco>
  <worldbody>
    <geom name="column" type="box" size="0.1 0.1 0.1" pos="0 0 -0.1"/>
    <body name="table">
      <joint name="j" axis="{axis}" pos="0 0 0.05"/>
      <geom name="disc" type="cylinder" size="0.1 0.05" pos="0 0 {height}"/>
    </body>
  </worldbody>
  <actuator><motor name="m" joint="j"/></actuator>
</mujoco>
"""


@pytest.mark.parametrize(
    ("axis", "height", "apart"),
    [
        pytest.param("0 0 1", 0.05, True, id="turns on its column"),
        pytest.param("0 0 1", 0.045, False, id="pressed into it"),
        pytest.param("0 1 0", 0.07, False, id="leans over until it touches"),
        pytest.param("0 1 0", 0.2, True, id="leans over far above"),
    ],
)
def test_what_a_joint_holds_at_one_distance_cannot_touch(axis: str, height: float, apart: bool) -> None:
    robot = Robot.from_string(TURNTABLE.format(axis=axis, height=height))
    found = without_collisions(robot, [np.linspace(-0.2, 0.2, 50)[:, None]])
    assert ((0, 1) in found) == apart


@pytest.mark.parametrize(("near", "apart"), [(0.02, False), (0.005, True)])
def test_how_near_is_near_can_be_told(robot: Robot, near: float, apart: bool) -> None:
    pair = robot.index("body", "left"), robot.index("body", "right")
    assert (pair in without_collisions(robot, [path(0.19)], near)) == apart  # they come within 11 mm
