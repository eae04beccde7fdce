"""Ordinary errors of a simulator: random relative errors of its parameters, and sensor noise. Not damage."""

from __future__ import annotations

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import model_errors
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.engines.closed_loop import ReadingOverride
from estexp_jax.physics.engines.controller_interface import Interface
from estexp_jax.physics.model.robot import Robot

_TAG, _NOISE_TAG = 41, 43
ANGLE_NOISE, FLIP_PROBABILITY = 0.005, 0.02
"""Standard deviation of an angle's noise, rad, and probability that a touch reading has the wrong sign."""


def perturbed_robots(robot: Robot, error: float, members: int, draw: int = 0) -> tuple[tuple[Change, ...], ...]:
    """Robots that differ from the nominal one by random relative errors, the same at each call.

    Args:
        robot: the nominal one.
        error: relative standard deviation.
        members: number of robots.
        draw: number of the draw; each gives other robots.
    """
    random = np.random.default_rng([_TAG, draw])
    return tuple(_perturbed(robot, error, random) for _ in range(members))


def sensor_noise(face: Interface, members: int, steps: int, draw: int = 0) -> ReadingOverride:
    """Noise on the networks' readings, arrays (members, steps, n_inputs), the same at each call of a draw."""
    random, shape = np.random.default_rng([_NOISE_TAG, draw]), (members, steps, face.n_inputs)
    angles, flips = ANGLE_NOISE * random.standard_normal(shape), random.random(shape) < FLIP_PROBABILITY
    return ReadingOverride(np.where(face.is_touch & flips, -1.0, 1.0), np.where(face.is_touch, 0.0, angles))


def _perturbed(robot: Robot, error: float, random: np.random.Generator) -> tuple[Change, ...]:
    sites = [(e, site) for e in model_errors() for site in e.sites(robot) if site != ALL_ALIKE]
    normal = random.standard_normal
    return tuple(Change(e.name, site or None, e.off_by(robot, site, error * normal())) for e, site in sites)
