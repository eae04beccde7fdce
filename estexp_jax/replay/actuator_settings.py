"""What was found of motors and joints, as frameworks for learning ask for it: one entry a motor."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from estexp_jax.physics.model.actuators import affine_actuators, gear_of
from estexp_jax.physics.model.robot import Robot

_ROUNDING = 1e-6


@final
@dataclass(frozen=True)
class ActuatorSettings:
    """One motor and its joint; N m, rad, s, for a slide N, m, s.

    The names are those of mjlab's actuator configurations; in Playground they are the fields of the model.

    Attributes:
        name: the actuator's.
        joint: its joint's.
        stiffness, damping: of a servo, at the joint; 0 of a motor.
        effort_limit: at the joint; None: unlimited.
        armature: of the joint.
        frictionloss: of the joint.
        viscous_damping: of the joint.
        delay: of commands, s.
        delay_min_lag, delay_max_lag: whole physics steps between which the delay lies.
    """

    name: str
    joint: str
    stiffness: float
    damping: float
    effort_limit: float | None
    armature: float
    frictionloss: float
    viscous_damping: float
    delay: float
    delay_min_lag: int
    delay_max_lag: int


def actuator_settings_of(robot: Robot) -> tuple[ActuatorSettings, ...]:
    """The settings of each motor of a robot that drives a hinge or slide."""
    affine = affine_actuators(robot.model)
    driving = [a for a in np.flatnonzero(affine).tolist() if robot.joint_of_actuator(a) in robot.scalar_joints]
    return tuple(_settings(robot, a) for a in driving)


def _settings(robot: Robot, actuator: int) -> ActuatorSettings:
    model, joint, gear = robot.model, robot.joint_of_actuator(actuator), gear_of(robot.model, actuator)
    assert joint is not None
    dof, step = int(model.jnt_dofadr[joint]), float(model.opt.timestep)
    delay = _delay(model, actuator)
    return ActuatorSettings(
        name=robot.names("actuator")[actuator],
        joint=robot.names("joint")[joint],
        stiffness=0.0 - float(model.actuator_biasprm[actuator, 1]) * gear**2,
        damping=0.0 - float(model.actuator_biasprm[actuator, 2]) * gear**2,
        effort_limit=_limit(model, actuator, joint, abs(gear)),
        armature=float(model.dof_armature[dof]),
        frictionloss=float(model.dof_frictionloss[dof]),
        viscous_damping=float(model.dof_damping[dof]),
        delay=delay,
        delay_min_lag=int(np.floor(delay / step + _ROUNDING)),
        delay_max_lag=int(np.ceil(delay / step - _ROUNDING)),
    )


def _delay(model: mujoco.MjModel, actuator: int) -> float:
    """By how much an actuator is late, s: held samples by whole steps."""
    samples, interpolation = (int(x) for x in model.actuator_history[actuator, :2])
    if samples <= 0:
        return 0.0
    step, delay = float(model.opt.timestep), float(model.actuator_delay[actuator])
    return delay if interpolation else step * max(np.ceil(delay / step - _ROUNDING), 1.0)


def _limit(model: mujoco.MjModel, actuator: int, joint: int, gear: float) -> float | None:
    """The smaller one of the motor's and the joint's."""
    limits = [np.abs(model.actuator_forcerange[actuator]).max() * gear] * bool(model.actuator_forcelimited[actuator])
    limits += [np.abs(model.jnt_actfrcrange[joint]).max()] * bool(model.jnt_actfrclimited[joint])
    return float(min(limits)) if limits else None
