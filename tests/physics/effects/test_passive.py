"""Springs and dampers that are written into descriptions act in the C engine as their equations say."""

import mujoco
import numpy as np
import pytest

from estexp_jax.discovery.export import explained_spec
from estexp_jax.physics.effects.changes import parse_change
from estexp_jax.physics.model.robot import Robot

XML = """
<mujoco model="spring">
  <compiler angle="{angle}"/>
  <worldbody><body><joint name="j" axis="0 1 0" {own}/><geom size="0.1" mass="1" pos="0.2 0 0"/></body></worldbody>
  <actuator><motor name="m" joint="j"/></actuator>
</mujoco>
"""
Q, W = np.linspace(-1.3, 1.2, 11), np.linspace(-3.0, 2.5, 11)


def forces(robot: Robot, text: str) -> tuple[np.ndarray, np.ndarray]:
    """Of springs and of dampers, (11,) each."""
    model = explained_spec(robot, [parse_change(t, robot) for t in text.split(" + ")]).compile()
    data, found = mujoco.MjData(model), []
    for q, w in zip(Q, W, strict=True):
        data.qpos[0], data.qvel[0] = q, w
        mujoco.mj_forward(model, data)
        found.append((data.qfrc_spring[0], data.qfrc_damper[0]))
    spring, damper = np.array(found).T
    return spring, damper


@pytest.mark.parametrize("angle", ["radian", "degree"])
@pytest.mark.parametrize("own", ["", "stiffness", "cubic"])
@pytest.mark.parametrize(
    ("text", "law"),
    [
        ("joint_stiffness@j k=1.5 q0=0.3", lambda q: -1.5 * (q - 0.3)),
        ("law_spring@j k=0.7 q0=-0.4", lambda q: -0.7 * (q + 0.4)),
        ("law_cube@j k=2 q0=0.3", lambda q: -2.0 * (q - 0.3) ** 3),
        ("law_cube@j k=-2 q0=0.3 + joint_stiffness@j k=3 q0=0.1", lambda q: 2.0 * (q - 0.3) ** 3 - 3.0 * (q - 0.1)),
    ],
)
def test_springs_add_up(angle, own, text, law):
    rest = 0.2 if angle == "radian" else np.degrees(0.2)
    kept = {"": "", "stiffness": "0.8", "cubic": "0.8 0 0.5"}[own]
    robot = Robot.from_string(XML.format(angle=angle, own=f'stiffness="{kept}" springref="{rest}"' if kept else ""))
    before = {"": 0.0 * Q, "stiffness": -0.8 * (Q - 0.2), "cubic": -0.8 * (Q - 0.2) - 0.5 * (Q - 0.2) ** 3}[own]
    spring, damper = forces(robot, text)
    np.testing.assert_allclose(spring, before + law(Q), atol=1e-9)
    assert not damper.any()


@pytest.mark.parametrize(
    ("text", "law"),
    [
        ("viscous_friction@j c=0.3", lambda w: -0.3 * w),
        ("quadratic_drag@j c=0.2", lambda w: -0.2 * np.abs(w) * w),
        ("law_damping@j c=0.1 + law_drag@j c=0.2", lambda w: -0.1 * w - 0.2 * np.abs(w) * w),
        ("law_cubic_drag@j c=-0.05 + quadratic_drag@j c=0.2", lambda w: 0.05 * w**3 - 0.2 * np.abs(w) * w),
    ],
)
def test_dampers_add_up(text, law):
    robot = Robot.from_string(XML.format(angle="radian", own='damping="0.1 0.05"'))
    spring, damper = forces(robot, text)
    np.testing.assert_allclose(damper, -0.1 * W - 0.05 * np.abs(W) * W + law(W), atol=1e-9)
    assert not spring.any()


def test_a_law_of_dry_friction_is_a_friction_loss():
    robot = Robot.from_string(XML.format(angle="radian", own='frictionloss="0.1"'))
    model = explained_spec(robot, [parse_change("law_dry_friction@j T=0.3", robot)]).compile()
    assert model.dof_frictionloss[0] == pytest.approx(0.4)


@pytest.mark.parametrize("text", ["armature@j I=0.03", "law_inertia@j I=0.03"])
def test_what_is_slow_to_start_adds_to_the_armature(text):
    robot = Robot.from_string(XML.format(angle="radian", own='armature="0.01"'))
    model = explained_spec(robot, [parse_change(text, robot)]).compile()
    assert model.dof_armature == pytest.approx([0.04])
