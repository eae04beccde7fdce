"""Robots for the tests of recordings: a pendulum with named and unnamed elements, and an arm with a servo."""

import pytest

from estexp_jax.physics.model.robot import Robot
from tests.recordings.checks.bad_logs import ARM

PENDULUM = """
<mujoco model="pendulum">
  <compiler angle="radian"/>
  <worldbody>
    <body name="arm">
      <joint name="hinge" type="hinge" axis="0 1 0" damping="0.1"/>
      <inertial pos="0 0 -0.1" mass="0.5" diaginertia="0.001 0.001 0.002"/>
      <site name="tip" pos="0 0 -0.2"/>
      <body name="hand" pos="0 0 -0.2">
        <joint type="slide" axis="0 0 1"/>
        <geom type="box" size="0.01 0.02 0.03" pos="0.01 0 0" euler="0.3 0.2 0.1"/>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position name="servo.1" joint="hinge" kp="2" kv="0.1" ctrlrange="-1 1"/>
    <motor site="tip"/>
  </actuator>
  <sensor>
    <jointpos name="angle" joint="hinge"/>
    <jointvel joint="hinge"/>
    <accelerometer name="acc" site="tip"/>
  </sensor>
</mujoco>
"""


@pytest.fixture
def pendulum() -> Robot:
    """Joints hinge, joint_1; actuators servo.1, actuator_1; sensors angle, sensor_1, acc (three values)."""
    return Robot.from_string(PENDULUM, "pendulum.xml")


@pytest.fixture
def pendulum_xml() -> str:
    """The MJCF of `pendulum`."""
    return PENDULUM


@pytest.fixture(scope="session")
def arm() -> Robot:
    """Joint elbow, actuator servo, sensors angle and rate."""
    return Robot.from_string(ARM, "arm.xml")
