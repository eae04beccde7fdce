"""What a controller sees and moves, on the paper's robot and on robots of others."""

import jax.numpy as jnp
import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.model.robot import Robot
from tests.physics.robots import MUTE, robot


def test_the_quadruped_has_the_papers_eight_and_eight() -> None:
    face = interface_of(robot("quadruped"))
    assert (face.n_inputs, face.n_outputs) == (8, 8)
    assert face.names == tuple(f"{kind}_{leg}" for kind in ("touch", "angle") for leg in "flbr")
    np.testing.assert_array_equal(face.is_touch, [True] * 4 + [False] * 4)
    np.testing.assert_allclose(face.commands(jnp.array([1.0, -1.0] * 4)), [np.pi / 4, -np.pi / 4] * 4, rtol=1e-6)
    np.testing.assert_array_equal(face.rest, [-1.0] * 4 + [0.0] * 4)


def test_angles_come_from_the_configuration_and_touch_from_the_last_step() -> None:
    face = interface_of(robot("quadruped"))
    qpos = jnp.arange(15.0) / 100.0
    sensordata = jnp.array([0.0, 3.0, -1.0, 1e-6, 9.0, 9.0, 9.0, 9.0])
    readings = face.readings(qpos, sensordata)
    np.testing.assert_allclose(readings, [-1.0, 1.0, -1.0, 1.0, 0.08, 0.10, 0.12, 0.14], rtol=1e-6)
    inputs = face.inputs(jnp.array([1.0, -1.0, 1.0, -1.0, np.pi / 4, -np.pi / 8, 2.0, 0.0]))
    np.testing.assert_allclose(inputs, [1.0, -1.0, 1.0, -1.0, 1.0, -0.5, 1.0, 0.0], rtol=1e-6)


def test_what_a_lost_part_takes_along() -> None:
    quadruped = robot("quadruped")
    face = interface_of(quadruped)
    parts = [f"{part}_{leg}" for leg in "flbr" for part in ("upper", "lower")]
    for row, part in zip(face.lost, parts, strict=True):
        np.testing.assert_array_equal(row, [name.endswith(part[-1]) for name in face.names])


def test_a_cart_pole_is_centred_on_its_home_keyframe() -> None:
    face = interface_of(robot("cartpole"))
    assert face.names == ("place", "lean")  # framepos is no input
    np.testing.assert_allclose(face.centre, [0.3, 0.1])
    np.testing.assert_allclose(face.scale, [2.0, np.pi / 4])  # half of the rail's range; the paper's swing
    np.testing.assert_allclose(face.inputs(jnp.array([1.3, 0.1 - np.pi / 8])), [0.5, -0.5], rtol=1e-5)
    # push: forces about zero up to the force range, within the control range; aim: angles about home.
    np.testing.assert_allclose(face.commands(jnp.array([1.0, 1.0])), [0.5, 0.2 + np.pi / 4], rtol=1e-6)
    np.testing.assert_allclose(face.commands(jnp.array([-1.0, -1.0])), [-0.5, 0.2 - np.pi / 4], rtol=1e-6)


def test_a_motor_is_scaled_by_the_smaller_of_its_ranges_and_a_geared_servo_by_its_gear() -> None:
    xml = """
    <mujoco>
      <compiler autolimits="true" angle="radian"/>
      <worldbody>
        <body><joint name="j"/><geom size="0.1"/></body>
        <body><joint name="s" type="slide"/><geom size="0.1"/></body>
      </worldbody>
      <actuator>
        <motor joint="j" ctrlrange="-3 3" forcerange="-8 8"/><motor joint="j" forcerange="-8 8"/><motor joint="j"/>
        <general joint="j" gainprm="4" forcerange="-8 8"/><position joint="j" gear="2"/><position joint="s"/>
        <velocity joint="j" ctrlrange="-5 5"/>
      </actuator>
      <sensor><jointpos joint="s"/></sensor>
    </mujoco>
    """
    face = interface_of(Robot.from_string(xml))
    np.testing.assert_allclose(face.ctrl_scale, [3.0, 8.0, 1.0, 2.0, np.pi / 2, 0.1, 5.0])
    np.testing.assert_array_equal(face.ctrl_centre, np.zeros(7))
    np.testing.assert_allclose(face.scale, [0.1])


JOINT = '<mujoco><worldbody><body><joint name="j"/><geom size="1"/><site name="s"/></body></worldbody>'
SENSOR = '<sensor><jointpos joint="j"/></sensor>'


@pytest.mark.parametrize(
    ("xml", "says"),
    [
        (f"{JOINT}<actuator><motor joint='j'/></actuator></mujoco>", "no touch and no jointpos"),
        (f"{JOINT}{SENSOR}</mujoco>", "no actuator"),
        (f"{JOINT}<actuator><motor name='jet' site='s'/></actuator>{SENSOR}</mujoco>", "jet"),
    ],
)
def test_a_robot_it_cannot_drive_is_refused_by_name(xml: str, says: str) -> None:
    with pytest.raises(InputError, match=says) as caught:
        interface_of(Robot.from_string(xml, "mine.xml"))
    assert "mine.xml" in str(caught.value)


def test_nothing_to_see_nothing_to_move() -> None:
    with pytest.raises(InputError, match="sensor"):
        interface_of(robot(MUTE))
