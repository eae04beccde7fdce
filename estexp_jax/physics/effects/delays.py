"""Delays and lags: how short ones can be told."""

from __future__ import annotations

from estexp_jax.physics.model.robot import Robot


def is_longer_than_step(robot: Robot, seconds: float) -> bool:
    """Whether a time is longer than a physics step of the model.

    An integrator of first order acts like a delay of half a step, so that shorter ones cannot be told from it.
    """
    return bool(seconds > robot.model.opt.timestep)
