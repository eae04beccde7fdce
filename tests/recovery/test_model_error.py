"""Ordinary errors of a simulator are as large as they should be."""

import numpy as np
import pytest

from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.cycle import Job
from estexp_jax.recovery.model_error import perturbed_robots, sensor_noise


def test_an_ensemble_is_as_wrong_as_it_should_be(quadruped: Robot) -> None:
    members = perturbed_robots(quadruped, 0.03, 200)
    losses = [c.parameters["loss"] for member in members for c in member if c.effect == "motor_weakness"]
    assert np.std(losses) == pytest.approx(0.03, rel=0.1)
    assert members == perturbed_robots(quadruped, 0.03, 200)


def test_noise_is_in_angles_and_turns_touch_round(job: Job) -> None:
    face = job.simulator.closed_loop.interface
    noise = sensor_noise(face, 3, 400)
    assert np.std(noise.added[..., ~face.is_touch]) == pytest.approx(0.005, rel=0.05)
    assert not np.any(noise.added[..., face.is_touch]) and np.all(noise.factor[..., ~face.is_touch] == 1.0)
    assert np.mean(noise.factor[..., face.is_touch] == -1.0) == pytest.approx(0.02, abs=0.006)
