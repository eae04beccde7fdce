"""How far a robot has come, whatever its root."""

from pathlib import Path

import jax.numpy as jnp
import mujoco
import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.travel import root_position
from tests.physics.robots import robot

BOX = '<geom size="0.1 0.1 0.1" type="box"/>'
TURNED = f"""
<mujoco>
  <worldbody>
    <body name="rail" pos="1 2 3" euler="0 0 30">
      <joint type="slide" axis="1 0 0" ref="0.4"/><joint type="slide" axis="0 1 1"/>{BOX}
    </body>
  </worldbody>
</mujoco>
"""


def _of_c_engine(subject: Robot, qpos: np.ndarray, body: int) -> np.ndarray:
    data = mujoco.MjData(subject.model)
    data.qpos[:] = qpos
    mujoco.mj_kinematics(subject.model, data)
    return data.xpos[body]


@pytest.mark.parametrize(
    "subject",
    [robot("quadruped"), robot("cartpole"), robot("slider"), Robot.from_string(TURNED, "turned")],
    ids=lambda r: Path(r.source).stem,
)
def test_it_is_where_the_c_engine_puts_the_root(subject: Robot) -> None:
    rng, travel = np.random.default_rng(0), root_position(subject)
    for _ in range(3):
        qpos = rng.normal(size=subject.model.nq)
        position = travel(jnp.asarray(qpos, jnp.float32))
        np.testing.assert_allclose(position, _of_c_engine(subject, qpos, 1), atol=1e-5)


@pytest.mark.parametrize("name", ["pendulum", "mute"])
def test_a_fixed_robot_cannot_travel(name: str) -> None:
    with pytest.raises(InputError, match=f"{name}.*freejoint"):
        root_position(robot(name))


def test_a_robot_without_joints_cannot_travel() -> None:
    with pytest.raises(InputError, match="freejoint"):
        root_position(Robot.from_string(f"<mujoco><worldbody><body>{BOX}</body></worldbody></mujoco>"))
