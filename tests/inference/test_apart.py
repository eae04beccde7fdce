"""Contacts between a robot's own parts are left out only where recordings never brought these near each other."""

import numpy as np
import pytest

from estexp_jax.inference.apart import excluded, kept_apart
from estexp_jax.physics.engines.lanes.model import lanes_refusal
from estexp_jax.physics.engines.mjx_model import mjx_model
from estexp_jax.physics.robot import Robot

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
    assert kept_apart(robot, [path(0.05), path(swing)]) == ([pair] if apart else [])


def test_a_robot_without_them_is_the_same_but_for_them(robot: Robot) -> None:
    found = excluded(robot, kept_apart(robot, [path(0.1)]))
    assert found.model.nexclude == 1 and robot.model.nexclude == 0
    assert found.names("geom") == robot.names("geom")
    assert excluded(robot, []) is robot
    refused = lanes_refusal(mjx_model(robot, ()), frozenset())
    assert refused is not None and "'lf'" in refused
    assert lanes_refusal(mjx_model(found, ()), frozenset()) is None
