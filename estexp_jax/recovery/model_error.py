"""Ordinary errors of a simulator: random relative errors of its parameters, and sensor noise. Not damage."""

from __future__ import annotations

import numpy as np

from estexp_jax.physics.effects.base import Effect
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import effect
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
    model = robot.model
    masses = {body: float(model.body_mass[robot.index("body", body)]) for body in _sites(robot, "body_mass")}
    joints = _sites(robot, "viscous_friction")
    damping = {j: float(model.dof_damping[model.jnt_dofadr[robot.index("joint", j)]]) for j in joints}
    normal = random.standard_normal
    return (
        *(Change("body_mass", body, {"dm": error * normal() * mass}) for body, mass in masses.items()),
        *(Change("motor_weakness", motor, {"loss": error * normal()}) for motor in _sites(robot, "motor_weakness")),
        *(Change("viscous_friction", joint, {"c": error * normal() * c}) for joint, c in damping.items()),
        *(
            Change("ground_friction", None, {"mu": _grip(robot, error * normal())})
            for _ in _sites(robot, "ground_friction")
        ),
    )


def _grip(robot: Robot, error: float) -> float:
    """Floor friction with an error. MuJoCo takes the larger of two frictions, so only an increase acts."""
    return float(robot.model.geom_friction[:, 0].max()) * (1.0 + abs(error))


def _sites(robot: Robot, name: str) -> tuple[str, ...]:
    e: Effect = effect(name)
    return tuple(site for site in e.sites(robot) if site != ALL_ALIKE)
