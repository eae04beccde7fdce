"""The robots that come with the package stand, fit the fast engine, and weigh what they should."""

import mujoco
import numpy as np
import pytest

from estexp_jax.lanes.capabilities import refusal
from estexp_jax.package_data import model_path
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.model.robot import Robot

ROBOTS = {"quadruped": (8, 8), "hexapod": (12, 12), "go1": (16, 12)}


@pytest.mark.parametrize("name", ROBOTS)
def test_robots_stand_and_have_no_meshes(name: str) -> None:
    robot = Robot.from_xml(model_path(name))
    model, data = robot.model, mujoco.MjData(robot.model)
    face = interface_of(robot)
    assert (face.n_inputs, face.n_outputs) == ROBOTS[name]
    assert model.nmesh == 0 and refusal(model) is None
    data.qpos[:], data.ctrl[:] = robot.home(), face.ctrl_centre
    mujoco.mj_step(model, data, round(2.0 / model.opt.timestep))
    assert np.linalg.norm(data.qpos[:3] - robot.home()[:3]) < 0.05
    assert data.xmat[1, 8] > 0.99 and np.abs(data.qvel).max() < 0.05  # upright, at rest
    feet = [s for s in range(model.nsensor) if int(model.sensor_type[s]) == int(mujoco.mjtSensor.mjSENS_TOUCH)]
    assert (data.sensordata[model.sensor_adr[feet]] > 0.0).all()


def test_the_go1_is_as_published() -> None:
    go1 = Robot.from_xml(model_path("go1")).model
    mass = {"trunk": 4.8, "hip_fl": 0.510299, "thigh_br": 0.898919, "calf_fr": 0.158015 + 0.06}
    assert {name: pytest.approx(float(go1.body(name).mass[0])) for name in mass} == mass
    assert go1.body("thigh_fl").pos.tolist() == [0.0, 0.08, 0.0] and go1.body("calf_fl").pos[2] == -0.213
    np.testing.assert_allclose(np.abs(go1.body("hip_br").pos), [0.1881, 0.04675, 0.0])
    left, right = (go1.body(name) for name in ("thigh_fl", "thigh_fr"))
    np.testing.assert_allclose(left.ipos, right.ipos * [1, -1, 1])
    np.testing.assert_allclose(np.sort(left.inertia), np.sort(right.inertia), rtol=1e-6)
