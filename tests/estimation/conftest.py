"""A robot with hinges, a slide and a free body, and recordings of it made of formulas."""

from collections.abc import Callable

import numpy as np
import pytest

from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

XML = """
<mujoco model="mixed">
  <compiler angle="radian"/>
  <worldbody>
    <body name="base">
      <joint name="hinge" axis="0 1 0"/>
      <geom size="0.1" mass="1"/>
      <site name="tip"/>
      <body name="rod" pos="0 0 1">
        <joint name="slide" type="slide" axis="0 0 1"/>
        <geom size="0.1" mass="1"/>
      </body>
    </body>
    <body name="ball" pos="3 0 1"><freejoint name="float"/><geom size="0.1" mass="1"/></body>
  </worldbody>
  <actuator><motor name="push" joint="slide"/></actuator>
  <sensor>
    <accelerometer name="acc" site="tip"/>
    <jointpos name="angle" joint="hinge"/>
    <jointvel name="speed" joint="slide"/>
  </sensor>
</mujoco>
"""


@pytest.fixture(scope="session")
def mixed() -> Robot:
    """Coordinates: hinge 0, slide 1, float 2:9; speeds: 0, 1, 2:8; readings: acc 0:3, angle 3, speed 4."""
    return Robot.from_string(XML, "mixed.xml")


@pytest.fixture
def blank(mixed: Robot) -> Callable[..., Recording]:
    """A recording of nothing at given times, with some columns filled in: `sensor={3: values}`."""

    def make(time: np.ndarray, name: str = "a.csv", **columns: dict[int, np.ndarray]) -> Recording:
        rows, model = len(time), mixed.model
        sizes = {"sensor": model.nsensordata, "qpos": model.nq, "qvel": model.nv}
        tables = {key: np.full((rows, n), np.nan) for key, n in sizes.items()}
        for key, filled in columns.items():
            for column, values in filled.items():
                tables[key][:, column] = values
        sensor, qpos, qvel = tables.values()
        return Recording(name, time, np.zeros((rows, 1)), np.ones((rows, 1)), sensor, qpos, qvel)

    return make
