"""Descriptions that were built in Python keep what they say when they are written."""

import mujoco
import pytest

from estexp_jax.physics.model.robot import Robot
from tests.versions import needs_mujoco_4


@needs_mujoco_4
def test_a_mass_at_the_origin_of_its_body_is_written() -> None:
    spec = mujoco.MjSpec()
    body = spec.worldbody.add_body(name="b", mass=7.0, inertia=[0.1] * 3, explicitinertial=True)
    body.add_joint(name="j")
    body.add_geom(size=[0.1, 0.0, 0.0])
    robot = Robot.from_spec(spec)
    for precise in (True, False):
        written = robot.spec.copy()
        written.compiler.savecompiled = not precise
        written.compile()
        again = mujoco.MjModel.from_xml_string(written.to_xml())
        assert again.body_mass[1] == pytest.approx(7.0)
        assert again.body_inertia[1] == pytest.approx([0.1] * 3)
