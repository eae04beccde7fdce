"""A folder as a user has it: a model and two logs; or a URDF with a mesh."""

from pathlib import Path

import numpy as np
import pytest

from estexp_jax.recordings.write import write_csv

ARM = """
<mujoco model="arm">
  <worldbody>
    <body>
      <joint name="elbow" axis="0 1 0"/>
      <geom type="capsule" fromto="0 0 0 0 0 -0.2" size="0.01"/>
    </body>
  </worldbody>
  <actuator><position name="servo" joint="elbow" kp="2" ctrlrange="-1 1"/></actuator>
  <sensor><jointpos name="angle" joint="elbow"/></sensor>
</mujoco>
"""
MANIFEST = """
model = "arm.xml"
[columns]
"ctrl.servo" = "goal"
[[recording]]
file = "a.csv"
[[recording]]
file = "b.csv"
role = "test"
"""


@pytest.fixture
def data(tmp_path, monkeypatch) -> Path:
    """arm.xml, and a.csv and b.csv with columns time, goal, sensor.angle and temp; it is the current folder."""
    folder = tmp_path / "data"
    folder.mkdir()
    (folder / "arm.xml").write_text(ARM)
    (folder / "recordings.toml").write_text(MANIFEST)
    for name, gap in (("a.csv", 0.0), ("b.csv", 0.5)):
        time = np.arange(100) * 0.01
        time[60:] += gap
        angle = np.where(np.arange(100) % 3 == 0, np.sin(5 * time), np.nan)
        write_csv(folder / name, {"time": time, "goal": np.sin(5 * time), "sensor.angle": angle, "temp": 20 + time})
    monkeypatch.chdir(folder)
    return folder


@pytest.fixture
def arm(tmp_path, monkeypatch) -> Path:
    """A folder with robot/arm.urdf and its mesh; robot is the current folder."""
    from tests.physics.meshes import urdf, write_box

    write_box(tmp_path / "robot" / "meshes" / "link.stl")
    (tmp_path / "robot" / "arm.urdf").write_text(urdf("package://arm/meshes/link.stl"))
    monkeypatch.chdir(tmp_path / "robot")
    return tmp_path
