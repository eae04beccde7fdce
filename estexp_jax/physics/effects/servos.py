"""Servos that feed back the speed of their joint, and how strongly."""

from __future__ import annotations

import numpy as np

from estexp_jax.physics.effects.sites import driven_actuators
from estexp_jax.physics.model.robot import Robot


def servos(robot: Robot) -> tuple[int, ...]:
    """Indices of the actuators that feed back the speed of a hinge or slide joint."""
    return tuple(a for a in driven_actuators(robot) if robot.model.actuator_biasprm[a, 2] < 0.0)


def goal_followers(robot: Robot) -> tuple[str, ...]:
    """Names of the actuators that feed back position or speed of a hinge or slide: their command is a goal."""
    feedback, names = robot.model.actuator_biasprm[:, 1:3], robot.names("actuator")
    return tuple(names[a] for a in driven_actuators(robot) if (feedback[a] < 0.0).any())


def servo_damping(robot: Robot) -> np.ndarray:
    """What the model says it is, N m s/rad at the joint, for each of `servos`."""
    own, model = list(servos(robot)), robot.model
    return -model.actuator_biasprm[own, 2] * model.actuator_gear[model.actuator_outadr[own], 0] ** 2


def servo_damping_at(robot: Robot, actuator: str) -> float:
    """What the model says it is at one actuator; 0 where that is no such servo."""
    names = [robot.names("actuator")[a] for a in servos(robot)]
    return float(servo_damping(robot)[names.index(actuator)]) if actuator in names else 0.0
