"""Bodies that a model welds: what is said of them, and the algebra of their motion."""

import numpy as np
import pytest

from estexp_jax.physics.effects.mounts import carried_joints, mount_sensors, mount_sites, solved, vector_product
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot
from tests.physics.robots import BOLTED, BOLTED_XML, robot


def test_a_bolted_body_carries_its_joints() -> None:
    assert mount_sites(robot(BOLTED)) == ("pedestal",) and carried_joints(robot(BOLTED), "pedestal") == ("pitch",)
    assert mount_sites(robot("pendulum")) == mount_sites(robot("quadruped")) == ()


def test_balls_and_other_sensors_leave_it_out() -> None:
    ball = BOLTED_XML.replace('name="pitch" axis="0 1 0"', 'type="ball"')
    ball = ball[: ball.index("<actuator>")] + "</mujoco>"
    assert mount_sites(Robot.from_string(ball, "ball.xml")) == ()
    seen = BOLTED_XML.replace("<sensor>", '<sensor><framepos objtype="body" objname="arm"/>')
    assert mount_sites(Robot.from_string(seen, "seen.xml")) == ()


def test_its_own_gyroscope_is_found_with_its_axes() -> None:
    sited = BOLTED_XML.replace('mass="20"/>', 'mass="20"/><site name="imu" pos="0 0.1 0.2" euler="0 0 90"/>')
    subject = Robot.from_string(sited.replace("<sensor>", '<sensor><gyro site="imu"/>'), "gyro.xml")
    [sensor] = mount_sensors(subject, "pedestal")
    assert mount_sites(subject) == ("pedestal",) and sensor.column == 0 and not sensor.accelerates
    np.testing.assert_allclose(sensor.axes, [[0, 1, 0], [-1, 0, 0], [0, 0, 1]], atol=1e-9)
    np.testing.assert_allclose(sensor.arm, [0, 0.1, 0.2], atol=1e-9)


def test_algebra() -> None:
    rng = np.random.default_rng(0)
    a, b, root = rng.normal(size=3), rng.normal(size=3), rng.normal(size=(3, 3))
    m = root @ root.T
    six = (m[0, 0], m[1, 1], m[2, 2], m[0, 1], m[0, 2], m[1, 2])
    np.testing.assert_allclose(solved(six, (b[0], b[1], b[2])), np.linalg.solve(m, b), rtol=1e-9)
    np.testing.assert_allclose(vector_product((a[0], a[1], a[2]), (b[0], b[1], b[2])), np.cross(a, b))


def test_its_inertia_is_that_of_all_it_carries() -> None:
    subject = robot(BOLTED)
    own = 20.0 * (0.2**2 + 1.0**2) / 12.0  # of the box; the arm, a rod at 0.6 m, adds
    rod = 0.4**2 / 3.0 + 0.6**2
    assert scales.carried_inertia(subject, subject.index("body", "pedestal")) == pytest.approx(own + rod, rel=0.03)
