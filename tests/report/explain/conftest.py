"""A diagnosis of an arm, for the pictures of robots."""

from types import SimpleNamespace

import numpy as np
import pytest

from estexp_jax.discovery.diagnosis import Prediction
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

ARM = """<mujoco><worldbody><body><joint name="a" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02"/>
<body pos="0 0 -.3"><joint name="b" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 0 0 -.3" size=".02"/></body></body>
</worldbody><sensor><jointvel joint="a"/><jointpos name="angle" joint="a"/></sensor></mujoco>"""


@pytest.fixture
def arm_diagnosis():
    """What ghosts need of a diagnosis: an arm whose nominal simulator is late, and then not."""
    arm, time = Robot.from_string(ARM), np.arange(100) * 0.01
    recorded = np.stack([np.cos(5 * time), np.sin(5 * time), 0.5 * np.sin(5 * time)], axis=1)
    nominal = recorded.copy()
    nominal[:50] *= 0.2
    channels = ("sensor_0", "angle", "qpos.b")
    prediction = Prediction("t.csv", "test", time, np.zeros(100), channels, recorded, nominal, recorded)
    qpos = np.stack([np.full(100, np.nan), recorded[:, 2]], axis=1)
    empty = np.zeros((100, 0))
    recording = Recording("t.csv", time, empty, empty, recorded[:, :2], qpos, np.full((100, 2), np.nan), "test")
    return SimpleNamespace(case=SimpleNamespace(robot=arm, recordings=[recording]), predictions=[prediction])
