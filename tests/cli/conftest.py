"""A folder as a user has it: a model and two logs. A pendulum that rubs, recorded and explained."""

from pathlib import Path

import numpy as np
import pytest

from estexp_jax.recordings.write import write_csv
from tests.cli.pendulum import EFFECT, PENDULUM, SMALL, run

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


@pytest.fixture(scope="session")
def recorded(tmp_path_factory) -> Path:
    """Recordings of a pendulum that rubs, as `estexp record` writes them."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / "pendulum.xml").write_text(PENDULUM)
    out = folder / "logs"
    sizes = ("--duration", "4", "--rate", "100", "--seed", "31")
    assert run("record", folder / "pendulum.xml", "--effect", EFFECT, "--out", out, *sizes) == 0
    return out


@pytest.fixture(scope="session")
def explained(recorded, tmp_path_factory) -> Path:
    """What `estexp explain` leaves of them."""
    out = tmp_path_factory.mktemp("explained") / "out"
    assert run("explain", recorded / "recordings.toml", "--out", out, *SMALL) == 0
    return out
