"""Missing forces show at what spacing a joint cogs."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.wave_guesses import likely_waves
from estexp_jax.physics.effects.catalogue.cogging import Cogging
from estexp_jax.physics.model.robot import Robot
from tests.discovery.planted import nominal


def seen(robot: Robot, force, rows: int = 1600) -> ForceResidual:
    """What a robot of one joint lacks along a motion of two tones, with noise."""
    rng, time = np.random.default_rng(31), np.arange(rows) / 200.0
    q = 0.9 * np.sin(2.1 * time) + 0.4 * np.sin(5.3 * time + 1.0)
    w = np.gradient(q, time)
    qpos, qvel, ctrl, motor = (x[:, None] for x in (q, w, np.zeros(rows), 0.3 * np.cos(3.0 * time)))
    noise = rng.normal(scale=0.05, size=rows)
    return ForceResidual(
        time, qpos, qvel, ctrl, motor, (force(q, w) + noise)[:, None], motor, motor, np.ones_like(motor)
    )


@pytest.mark.parametrize("n", [5.3, 21.0, 44.0])
def test_a_wave_is_seen_beside_friction_a_spring_and_noise(n: float) -> None:
    robot = nominal("one")
    [site] = robot.scalar_joints
    joint = robot.names("joint")[site]

    def force(q: np.ndarray, w: np.ndarray) -> np.ndarray:
        return 0.12 * np.sin(n * q + 0.7) - 0.4 * np.sign(w) - 0.2 * w + 0.5 * (q - 0.3)

    amplitude, spacing, phase = likely_waves(robot, [seen(robot, force)], [Cogging()])[Cogging.name, joint][0]
    assert spacing == pytest.approx(n, abs=0.5)
    assert amplitude == pytest.approx(0.12, rel=0.2)
    assert abs(np.angle(np.exp(1j * (phase - 0.7)))) < 0.4


def test_a_joint_that_stands_still_shows_none() -> None:
    robot = nominal("one")
    still = seen(robot, lambda q, w: 0.0 * q)
    still = replace(still, qpos=0.0 * still.qpos, qvel=0.0 * still.qvel)
    assert likely_waves(robot, [still], [Cogging()]) == {}
