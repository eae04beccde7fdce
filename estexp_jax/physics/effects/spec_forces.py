"""Forces on bodies and shares of motors' forces, written into descriptions."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from estexp_jax.physics.effects.new_elements import CONSTANT, add_passive_motor, add_tendon, free_name
from estexp_jax.physics.effects.spec_drives import feeds_back, motors_of
from estexp_jax.physics.model.actuators import affine_actuators, gear_of
from estexp_jax.physics.model.robot import Robot, spec_element

_SITES = 4
"""Group of sites that viewers do not show at first."""


def add_force(robot: Robot, spec: mujoco.MjSpec, body: str, force: Sequence[float]) -> None:
    """Let a constant force, N in world axes, act on a body at its centre of mass.

    Its site is referred to one of the world, so that it does not turn with the body.
    """
    motor = add_passive_motor(spec, f"{body}_force", cogging=(1.0, *CONSTANT))
    motor.trntype = mujoco.mjtTrn.mjTRN_SITE
    motor.target, motor.refsite = _centre(robot, spec, body).name, _site(spec, spec.worldbody, "world_axes").name
    motor.gear = [*force, 0.0, 0.0, 0.0]


def add_pull(robot: Robot, spec: mujoco.MjSpec, body: str, stiffness: float, point: Sequence[float]) -> None:
    """Let a spring, N/m, pull a body's centre of mass to a point in the world, m."""
    tendon = add_tendon(spec, f"{body}_pull")
    tendon.wrap_site(_site(spec, spec.worldbody, f"{body}_pulled_to", point).name)
    tendon.wrap_site(_centre(robot, spec, body).name)
    tendon.stiffness = [stiffness, 0.0, 0.0]


def _centre(robot: Robot, spec: mujoco.MjSpec, body: str) -> Any:
    there = spec_element(spec, robot, "body", body)
    nominal = robot.model.body_ipos[robot.index("body", body)]
    return _site(spec, there, f"{body}_centre", there.ipos if there.explicitinertial else nominal)


def _site(spec: mujoco.MjSpec, body: Any, name: str, place: Sequence[float] = (0.0, 0.0, 0.0)) -> Any:
    return body.add_site(name=free_name([s.name for s in spec.sites], name), pos=list(place), group=_SITES)


def share_refusal(robot: Robot, joint: str) -> str:
    """Why another joint cannot be given a share of what a joint's motors give; empty where it can."""
    if any(feeds_back(robot, a) for a in motors_of(robot, joint)):
        return "a servo that pulls on two joints would see both"
    return ""


def add_share(robot: Robot, spec: mujoco.MjSpec, motors: Sequence[int], joint: str, share: float) -> None:
    """Let motors pull on one more joint, with a share of their torque at their own.

    Args:
        robot: the nominal robot.
        spec: its description.
        motors: indices of actuators, each of one joint.
        joint: the other joint's name.
        share: of the torque.
    """
    for a in motors:
        actuator = spec_element(spec, robot, "actuator", robot.names("actuator")[a])
        if actuator.trntype == mujoco.mjtTrn.mjTRN_TENDON:
            spec.tendon(actuator.target).wrap_joint(joint, share)
            continue
        tendon = add_tendon(spec, f"{actuator.name}_shared", ((actuator.target, 1.0), (joint, share)))
        actuator.trntype, actuator.target = mujoco.mjtTrn.mjTRN_TENDON, tendon.name


def tie_refusal(robot: Robot, actuator: int, other: int) -> str:
    """Why an actuator cannot be made to do what another's command asks for; empty where it can."""
    model = robot.model
    if not affine_actuators(model)[[actuator, other]].all() or robot.joint_of_actuator(other) is None:
        return "MuJoCo gives each actuator a command of its own"
    plain = not model.actuator_biasprm[[actuator, other]].any() and not model.actuator_dyntype[[actuator, other]].any()
    limited = model.actuator_forcelimited[[actuator, other]].any()
    works = gear_of(model, other) * model.actuator_gainprm[other, 0] != 0.0
    two = robot.joint_of_actuator(other) != robot.joint_of_actuator(actuator)
    return "" if plain and not limited and works and two else "of two servos, each sees its own joint"


def tie(robot: Robot, spec: mujoco.MjSpec, actuator: int, other: int) -> None:
    """Let the other actuator pull on this one's joint as well, and this one on nothing."""
    model, names = robot.model, robot.names("actuator")
    pull, own = (gear_of(model, a) * float(model.actuator_gainprm[a, 0]) for a in (other, actuator))
    joint = robot.joint_of_actuator(actuator)
    assert joint is not None
    add_share(robot, spec, (other,), robot.names("joint")[joint], own / pull)
    spec_element(spec, robot, "actuator", names[actuator]).gainprm = np.zeros(10)
