"""Settings act as if they stood in the XML, on a copy."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.settings import apply_settings


def _same_physics(robot: Robot, xml: str) -> None:
    """Equal to the robot whose XML was edited by hand, in every number of the model."""
    expected = Robot.from_string(xml).model
    for name in ("gainprm", "biasprm", "forcerange", "forcelimited", "ctrlrange", "gear"):
        np.testing.assert_array_equal(
            getattr(robot.model, f"actuator_{name}"), getattr(expected, f"actuator_{name}"), name
        )
    for name in ("dof_damping", "dof_armature", "jnt_range", "jnt_limited", "body_mass", "body_inertia", "site_pos"):
        np.testing.assert_array_equal(getattr(robot.model, name), getattr(expected, name), name)
    np.testing.assert_array_equal(robot.model.opt.gravity, expected.opt.gravity)
    assert robot.model.opt.timestep == expected.opt.timestep


@pytest.mark.parametrize(
    ("settings", "old", "new"),
    [
        ({"actuator.servo.1.kp": 5.0}, 'kp="2"', 'kp="5"'),
        ({"actuator.servo.1.kv": 0.7, "actuator.servo.1.kp": 3}, 'kp="2" kv="0.1"', 'kp="3" kv="0.7"'),
        ({"actuator.servo.1.forcerange": (-2, 2)}, 'kp="2"', 'kp="2" forcerange="-2 2"'),
        ({"actuator.actuator_1.gear": [0, 3.0]}, '<motor site="tip"/>', '<motor site="tip" gear="0 3"/>'),
        ({"joint.hinge.damping": 0.4}, 'damping="0.1"', 'damping="0.4"'),
        ({"joint.joint_1.armature": 0.4}, 'type="slide"', 'type="slide" armature="0.4"'),
        ({"joint.hinge.range": (-0.5, 0.5)}, 'damping="0.1"', 'damping="0.1" range="-0.5 0.5"'),
        ({"geom.geom_0.density": 500}, 'type="box"', 'type="box" density="500"'),
        ({"site.tip.pos": [0, 0, 1]}, 'name="tip" pos="0 0 -0.2"', 'name="tip" pos="0 0 1"'),
        ({"option.timestep": 0.001}, "<worldbody>", '<option timestep="0.001"/><worldbody>'),
        ({"option.gravity": [0, 0, -3]}, "<worldbody>", '<option gravity="0 0 -3"/><worldbody>'),
    ],
)
def test_a_setting_is_the_edited_xml(pendulum, pendulum_xml, settings, old, new):
    before = pendulum.spec.to_xml()
    assert pendulum_xml.count(old) == 1
    _same_physics(apply_settings(pendulum, settings), pendulum_xml.replace(old, new))
    assert pendulum.spec.to_xml() == before


ACTUATORS = """<mujoco><worldbody><body><joint name="h"/><geom size=".1"/></body></worldbody>
  <actuator><{} name="a" joint="h"/></actuator></mujoco>"""


@pytest.mark.parametrize(
    ("old", "key", "new"),
    [
        ('velocity kv="2"', "kv", 'velocity kv="0.5"'),
        ('damper ctrlrange="0 1" kv="2"', "kv", 'damper ctrlrange="0 1" kv="0.5"'),
        ('intvelocity actrange="-1 1" kp="2"', "kp", 'intvelocity actrange="-1 1" kp="0.5"'),
        ('position kp="2" dampratio="1"', "kp", 'position kp="0.5" dampratio="1"'),
        ('pid kp="2" kv="1"', "kv", 'pid kp="2" kv="0.5"'),
        ('general biastype="affine" gainprm="2" biasprm="0 -2 -.1"', "kp", 'position kp="0.5" kv=".1"'),
        ('general biastype="affine" gainprm="2" biasprm="0 0 -2"', "kv", 'velocity kv="0.5"'),
    ],
)
def test_gains_of_other_actuators(old, key, new):
    robot = apply_settings(Robot.from_string(ACTUATORS.format(old)), {f"actuator.a.{key}": 0.5})
    expected = Robot.from_string(ACTUATORS.format(new)).model
    np.testing.assert_array_equal(robot.model.actuator_gainprm, expected.actuator_gainprm)
    np.testing.assert_array_equal(robot.model.actuator_biasprm, expected.actuator_biasprm)


@pytest.mark.parametrize("compiler", ["", '<compiler inertiafromgeom="true"/>', '<compiler settotalmass="7"/>'])
@pytest.mark.parametrize(
    "inertia",
    [
        '<geom type="box" size="0.01 0.02 0.03" pos="0.01 0 0" euler="10 20 30"/>',
        '<geom size="0.1"/><inertial pos="0 0 0.1" mass="1" fullinertia="0.1 0.2 0.25 0.01 0.02 0.03"/>',
        '<geom size="0.1"/><inertial pos="0 0 0.1" mass="1" diaginertia="0.1 0.2 0.25" euler="10 20 30"/>',
    ],
)
def test_mass_scales_inertia_and_leaves_the_others(compiler, inertia):
    xml = f"""<mujoco>{compiler}<worldbody><body name="a.b"><joint/>{inertia}
      <body name="c"><joint/><geom size="0.1"/></body></body></worldbody></mujoco>"""
    robot = Robot.from_string(xml)
    heavy = apply_settings(robot, {"body.a.b.mass": 3.0})
    scale = 3.0 / robot.model.body_mass[1]
    np.testing.assert_allclose(heavy.model.body_mass[1:], [3.0, robot.model.body_mass[2]])
    np.testing.assert_allclose(heavy.model.body_inertia[1], scale * robot.model.body_inertia[1])
    np.testing.assert_allclose(heavy.model.body_inertia[2], robot.model.body_inertia[2])
    np.testing.assert_allclose(heavy.model.body_ipos, robot.model.body_ipos, atol=1e-15)
    np.testing.assert_allclose(heavy.model.body_iquat, robot.model.body_iquat, atol=1e-15)


def test_degrees_stay_degrees_and_quaternions_win():
    xml = """<mujoco><compiler angle="degree"/><worldbody><body name="a" euler="0 0 90"><joint name="h" range="-45 45"/>
      <geom size="0.1"/></body></worldbody></mujoco>"""
    model = apply_settings(Robot.from_string(xml), {"joint.h.range": (-30, 30), "body.a.quat": (1, 0, 0, 0)}).model
    np.testing.assert_allclose(model.jnt_range, np.radians([[-30, 30]]))
    np.testing.assert_array_equal(model.body_quat[1], [1, 0, 0, 0])


def test_nothing_to_set_is_the_same_robot(pendulum):
    assert apply_settings(pendulum, {}) is pendulum


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("motor.servo.kp", 1.0, r"unknown element 'motor'; known are: joint, actuator"),
        ("actuator.knee.kp", 1.0, r"there is no actuator 'knee'; known are: servo\.1, actuator_1"),
        ("joint.hinge.colour", 1.0, r"unknown attribute 'colour' of joint; known are: pos, axis"),
        ("option.colour", 1.0, r"unknown attribute 'colour' of option; known are: timestep"),
        ("joint.damping", 1.0, "is not a setting; joint"),
        ("option", 1.0, "is not a setting; option"),
        ("actuator.actuator_1.kp", 1.0, "this actuator has no kp"),
        ("body.world.mass", 1.0, "the world cannot be set"),
        ("body.arm.mass", 0.0, "is 0.0, not above zero"),
        ("option.timestep", -1.0, "is -1.0, not above zero"),
        ("option.iterations", 1.5, "is 1.5, not a whole number"),
        ("joint.hinge.damping", "high", "is 'high', not a finite number"),
        ("joint.hinge.range", 1.0, "has 1 numbers; 2 numbers"),
        ("joint.hinge.damping", [1, 2, 3, 4], "has 4 numbers; at most 3 numbers"),
        ("actuator.servo.1.forcerange", [1, -1], "not low to high"),
        ("joint.hinge.axis", [0, 0, 0], "does not compile"),
    ],
)
def test_wrong_settings_say_what_exists(pendulum, key, value, message):
    with pytest.raises(InputError, match=message) as caught:
        apply_settings(pendulum, {key: value}, where="recordings.toml, set")
    assert str(caught.value).startswith("recordings.toml, set")


def test_a_place_given_by_fromto_is_not_silently_kept():
    xml = '<mujoco><worldbody><geom name="g" type="capsule" fromto="0 0 0 0 0 1" size=".1"/></worldbody></mujoco>'
    with pytest.raises(InputError, match="set fromto instead"):
        apply_settings(Robot.from_string(xml), {"geom.g.pos": (0, 0, 0)})
