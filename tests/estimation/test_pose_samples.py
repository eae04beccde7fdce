"""Poses of free and ball joints are read from the sensors of the body that they move."""

import mujoco
import numpy as np
import pytest

from estexp_jax.estimation.pose_samples import pose_samples
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

BODY = """
<mujoco><worldbody><body name="mount" pos=".1 .2 .3" euler="10 20 30"><body name="head" pos="0 0 1" euler="40 0 0">
<joint name="neck" type="{}"/><geom type="box" size=".1 .2 .3" pos=".1 0 0" mass="1"/>
<site name="imu" pos=".1 .2 .3" euler="30 40 50"/></body></body></worldbody><sensor>{}</sensor></mujoco>
"""
FREE = BODY.replace('<body name="mount" pos=".1 .2 .3" euler="10 20 30">', "").replace(
    "</body></body></worldbody>", "</body></worldbody>"
)
ON_SITE = '<framequat objtype="site" objname="imu"/><gyro site="imu"/><framepos objtype="site" objname="imu"/>'
ON_BODY = '<framequat objtype="xbody" objname="head"/><gyro site="imu"/><framepos objtype="body" objname="head"/>'
ON_BODY += '<framelinvel objtype="xbody" objname="head"/>'
OWN = '<ballquat joint="neck"/><ballangvel joint="neck"/>'
ROWS = 20


def recorded(one: Robot) -> tuple[Recording, np.ndarray, np.ndarray]:
    """Readings in random states, and these."""
    rng, data, rows = np.random.default_rng(0), mujoco.MjData(one.model), []
    for _ in range(ROWS):
        data.qpos[:], data.qvel[:] = rng.normal(size=one.model.nq), rng.normal(size=one.model.nv)
        mujoco.mj_normalizeQuat(one.model, data.qpos)
        mujoco.mj_forward(one.model, data)
        rows.append((data.sensordata.copy(), data.qpos.copy(), data.qvel.copy()))
    sensor, qpos, qvel = map(np.array, zip(*rows, strict=True))
    no_place, no_speed = (np.full((ROWS, n), np.nan) for n in (one.model.nq, one.model.nv))
    empty = np.zeros((ROWS, 0))
    return Recording("r.csv", 0.01 * np.arange(ROWS), empty, empty, sensor, no_place, no_speed), qpos, qvel


def same_turns(one: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.allclose(np.abs(np.sum(one * other, axis=1)), 1.0, atol=1e-9))


@pytest.mark.parametrize("sensors", [OWN, ON_SITE, ON_BODY])
def test_a_ball_joint_is_read_from_its_own_sensors_or_those_of_its_body(sensors: str) -> None:
    one = Robot.from_string(BODY.format("ball", sensors))
    recording, qpos, qvel = recorded(one)
    found = pose_samples(one, recording, 0)
    assert same_turns(found.turn, qpos)
    np.testing.assert_allclose(found.spin, qvel, atol=1e-9)


@pytest.mark.parametrize("sensors", [ON_SITE, ON_BODY])
def test_a_free_joint_is_read_from_any_frame_on_its_body(sensors: str) -> None:
    one = Robot.from_string(FREE.format("free", sensors))
    recording, qpos, qvel = recorded(one)
    found = pose_samples(one, recording, 0)
    assert same_turns(found.turn, qpos[:, 3:])
    np.testing.assert_allclose(found.spin, qvel[:, 3:], atol=1e-9)
    if "framelinvel" in sensors:
        np.testing.assert_allclose(found.speed, qvel[:, :3], atol=1e-9)
    else:
        np.testing.assert_allclose(found.place, qpos[:, :3], atol=1e-9)
        assert np.isnan(found.speed).all()


def test_columns_of_the_state_come_first_and_moving_mounts_tell_nothing() -> None:
    one = Robot.from_string(BODY.format("ball", ON_SITE))
    recording, qpos, _ = recorded(one)
    recording.qpos[:] = -qpos
    assert np.array_equal(pose_samples(one, recording, 0).turn, -qpos)
    moving = Robot.from_string(
        BODY.format("ball", ON_SITE).replace('euler="10 20 30">', 'euler="10 20 30"><joint/><geom size=".1"/>')
    )
    recording, _, _ = recorded(moving)
    found = pose_samples(moving, recording, 1)
    assert np.isnan(found.turn).all() and np.isnan(found.spin).all()
