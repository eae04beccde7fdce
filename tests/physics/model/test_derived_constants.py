"""Derived constants, where they are easy to get wrong: free and ball joints, sliders, welded parts, fixed bodies."""

from pathlib import Path

import jax
import jax.numpy as jnp
import numpy as np
import pytest
from mujoco import mjx

from estexp_jax.physics.model.derived_constants import refresh
from estexp_jax.physics.model.robot import Robot
from tests.physics.robots import ROBOTS, robot

WELDED = """
<mujoco>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="post"><geom size="0.1" mass="3"/></body>
    <body name="float" pos="0 0 1"><freejoint/><geom size="0.1" mass="1" pos="0.1 0 0"/>
      <body name="welded" pos="0.3 0 0"><geom size="0.1" mass="2"/>
        <body name="flap"><joint axis="0 1 0" armature="0.01"/><geom size="0.05" mass="0.5" pos="0 0.2 0"/></body>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


SUBJECTS = (*map(robot, ROBOTS), robot("slider"), Robot.from_string(WELDED, "welded"))
HEAVIER = 3.0


@pytest.mark.parametrize("subject", SUBJECTS, ids=lambda r: Path(r.source).stem)
def test_they_are_the_compilers(subject: Robot) -> None:
    model = subject.model
    nominal = mjx.put_model(model)
    nominal = nominal.replace(  # a stale model: heavy, with the constants of a light one
        body_mass=nominal.body_mass * HEAVIER,
        body_inertia=nominal.body_inertia * HEAVIER,
        dof_armature=nominal.dof_armature * HEAVIER,
        body_invweight0=jnp.zeros_like(nominal.body_invweight0),
    )
    ours = jax.jit(lambda m: refresh(subject, m))(nominal)
    # All inertia scaled alike scales every inverse alike.
    np.testing.assert_allclose(ours.dof_invweight0, model.dof_invweight0 / HEAVIER, rtol=2e-4)
    np.testing.assert_allclose(ours.body_invweight0, model.body_invweight0 / HEAVIER, rtol=2e-4, atol=1e-7)
    np.testing.assert_allclose(ours.body_subtreemass, model.body_subtreemass * HEAVIER, rtol=1e-5)
