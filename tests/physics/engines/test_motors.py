"""Motor torques as the C engine has them, and how large the program takes motors and joints to be."""

from pathlib import Path

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
import pytest
from mujoco import mjx

from estexp_jax.physics.engines.motors import motor_torques
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot
from tests.physics.robots import MUTE, ROBOTS, robot

ZOO = """
<mujoco>
  <compiler angle="radian" autolimits="true"/>
  <worldbody>
    <body name="root">
      <freejoint/><geom size="0.1" mass="1"/><site name="nose"/>
      <body pos="0.3 0 0"><joint name="a" axis="0 1 0"/><geom size="0.1" mass="1"/>
        <body pos="0.3 0 0"><joint name="b" type="slide" axis="1 0 0"/><geom size="0.1" mass="1"/>
          <body pos="0.3 0 0">
            <joint name="c" axis="0 0 1" actuatorfrcrange="-0.8 0.5"/><geom size="0.1" mass="1"/>
          </body>
        </body>
      </body>
    </body>
  </worldbody>
  <actuator>
    <position joint="a" kp="3" kv="0.2" gear="2" ctrlrange="-0.5 0.5" forcerange="-1 2"/>
    <velocity joint="a" kv="0.7" gear="-1.5"/>
    <motor joint="b" gear="4" ctrlrange="-0.3 0.6"/>
    <general joint="b" gaintype="affine" gainprm="2 0.5 -0.3" biastype="affine" biasprm="0.1 -0.4 -0.2"/>
    <general joint="c" gainprm="3" biasprm="5 5 5" forcerange="-1 1"/>
    <damper joint="c" kv="0.4" ctrlrange="0 1"/>
    <motor site="nose" gear="1 0 0 0 0 0"/>
  </actuator>
</mujoco>
"""


@pytest.mark.parametrize(
    "subject", [Robot.from_string(ZOO), *map(robot, [*ROBOTS, MUTE])], ids=lambda r: Path(r.source).stem
)
def test_torques_are_those_of_the_c_engine(subject: Robot) -> None:
    model, data, rng = subject.model, mujoco.MjData(subject.model), np.random.default_rng(0)
    torques = jax.jit(lambda q, v, u: motor_torques(subject, mjx.put_model(model), q, v, u))
    sites = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_SITE)
    for size in (0.1, 1.0, 3.0):
        data.qpos[:] = model.qpos0 + size * rng.normal(size=model.nq)
        data.qvel[:], data.ctrl[:] = size * rng.normal(size=model.nv), size * rng.normal(size=model.nu)
        data.ctrl[sites] = 0.0  # thrusters are not motors of a joint
        mujoco.mj_normalizeQuat(model, data.qpos)
        mujoco.mj_forward(model, data)
        ours = torques(*(jnp.asarray(x, jnp.float32) for x in (data.qpos, data.qvel, data.ctrl)))
        np.testing.assert_allclose(ours, data.qfrc_actuator, atol=1e-4 * max(1.0, np.abs(data.qfrc_actuator).max()))


def test_the_limit_of_a_motor_is_its_largest_torque() -> None:
    zoo = Robot.from_string(ZOO)
    limits = [scales.motor_limit(zoo, a) for a in range(5)]
    np.testing.assert_allclose(limits, [2 * 2.0, 1.5 * 0.7 * np.pi / 2, 4 * 0.6, 2 * 0.1, 1.0])


def test_the_inertia_of_a_joint_is_that_of_all_it_carries() -> None:
    arm = Robot.from_string("""
    <mujoco><worldbody><body><joint name="j" axis="0 1 0" armature="0.1"/>
      <inertial pos="0 0 -0.5" mass="2" diaginertia="0.01 0.02 0.03"/></body></worldbody></mujoco>""")
    assert scales.joint_inertia(arm, 0) == pytest.approx(0.1 + 0.02 + 2 * 0.25)
    assert scales.gravity_torque(arm, 0) == pytest.approx(2 * 9.81 * 0.5, rel=1e-6)
    assert scales.joint_torque(arm, 0) == pytest.approx(2 * 9.81 * 0.5, rel=1e-6)


def test_a_joint_without_motor_or_weight_still_has_a_scale() -> None:
    upright = Robot.from_string("""
    <mujoco><worldbody><body><joint axis="0 0 1"/><geom size="0.1" mass="1"/></body></worldbody></mujoco>""")
    assert scales.joint_torque(upright, 0) == pytest.approx(10 * scales.joint_inertia(upright, 0))
