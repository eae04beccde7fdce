"""What is added to a description takes nothing over from its defaults."""

import mujoco
import pytest

from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.effects.written import written
from estexp_jax.physics.model.robot import Robot

DEFAULTS = """
<mujoco>
  <compiler angle="degree" autolimits="true"/>
  <default>
    <joint range="-30 30" damping="0.4" stiffness="2" frictionloss="0.3" armature="0.2"/>
    <general forcerange="-0.1 0.1" gear="3" ctrlrange="-1 1"/>
    <tendon range="-0.1 0.1" stiffness="5" damping="0.2" frictionloss="0.1"/>
  </default>
  <worldbody>
    <body><joint name="elbow" axis="0 1 0"/><geom size="0.1" pos="0.2 0 0" mass="0.4"/></body>
  </worldbody>
  <actuator><motor name="lift" joint="elbow"/></actuator>
</mujoco>
"""


def _model(text: str) -> mujoco.MjModel:
    robot = Robot.from_string(DEFAULTS)
    return written(robot, [parse_change(text, robot)]).compile()


def test_a_motor_without_windings():
    model = _model("cogging@elbow A=0.5 n=4 phase=1.5707963")
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert data.actuator_force[1] == pytest.approx(0.5) == data.qfrc_actuator[0] and model.nu == 1


def test_a_rotor_and_its_tendon():
    model = _model("joint_compliance@elbow k=50 d=0.1 I=0.01")
    rotor, tendon = model.joint("elbow_rotor"), model.tendon("elbow_spring")
    assert not rotor.limited[0] and not model.tendon_limited[tendon.id]
    assert (rotor.damping[0], rotor.stiffness[0], rotor.frictionloss[0], rotor.armature[0]) == (0, 0, 0, 0.01)
    assert (model.tendon_stiffness[0], model.tendon_damping[0], model.tendon_frictionloss[0]) == (50, 0.1, 0)
    assert model.actuator("lift").trnid[0] == rotor.id
