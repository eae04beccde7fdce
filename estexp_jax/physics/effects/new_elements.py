"""Elements of MuJoCo's own that are added to a description: they take nothing over from the model's defaults.

What is added stands after what is there and drives no command, so that addresses of states, commands and readings
stay as they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

CONSTANT = (0.0, float(np.pi / 2.0))
"""Poles and phase with which cogging is a constant torque."""
_NO_LIMIT = mujoco.mjtLimited.mjLIMITED_FALSE


def add_passive_motor(
    spec: mujoco.MjSpec,
    name: str,
    joint: str = "",
    *,
    cogging: Sequence[float] = (0.0, 0.0, 0.0),
    lugre: Sequence[float] = (),
) -> Any:
    """Add a DC motor without command and windings: what is left of it are its magnets and its bearings.

    Args:
        spec: the description.
        name: of the motor, where it is free.
        joint: its joint; empty: the caller says what it acts on.
        cogging: A, n, phase of the torque A sin(n q + phase).
        lugre: stiffness s0 and damping s1 of bristles, levels Fc and Fs of sliding and at rest, speed vs between them.

    Source: MuJoCo documentation, XML reference, actuator/dcmotor.
    """
    motor = spec.add_actuator(name=free_name([a.name for a in spec.actuators], name))
    motor.trntype, motor.target = mujoco.mjtTrn.mjTRN_JOINT, joint
    motor.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    motor.ctrllimited = motor.forcelimited = motor.actlimited = _NO_LIMIT
    motor.delay, motor.nsample, motor.damping, motor.armature = 0.0, 0, [0.0, 0.0, 0.0], 0.0
    motor.dyntype, motor.gaintype = mujoco.mjtDyn.mjDYN_DCMOTOR, mujoco.mjtGain.mjGAIN_DCMOTOR
    motor.biastype, motor.ctrlspec = mujoco.mjtBias.mjBIAS_DCMOTOR, int(mujoco.mjtCtrlInput.mjINPUT_NONE)
    motor.actdim, motor.actearly = int(bool(lugre)), True
    s0, s1, *levels = lugre or (0.0, 0.0, 0.0, 0.0, 0.0)
    motor.gainprm = _filled([1.0])
    motor.biasprm = _filled([*cogging, *levels])
    motor.dynprm = _filled([0.0, 0.0, 0.0, 0.0, 0.0, s0, s1])
    return motor


def add_tendon(spec: mujoco.MjSpec, name: str, shares: Sequence[tuple[str, float]] = ()) -> Any:
    """Add a tendon, as long as joints are turned times their shares; without shares the caller says where it runs."""
    tendon = spec.add_tendon(name=free_name([t.name for t in spec.tendons], name))
    tendon.limited = tendon.actfrclimited = _NO_LIMIT
    tendon.stiffness, tendon.damping, tendon.frictionloss = [0.0] * 3, [0.0] * 3, 0.0
    tendon.armature, tendon.springlength, tendon.group = 0.0, [0.0, 0.0], _HIDDEN
    for joint, share in shares:
        tendon.wrap_joint(joint, share)
    return tendon


def add_rotor(spec: mujoco.MjSpec, joint: Any, inertia: float) -> Any:
    """Add a rotor beside a hinge or slide: a joint of the same zero, with an inertia of its own and nothing else.

    It stands in the world, last of all, for it moves with nothing: what it does to the robot goes through a tendon.
    """
    name = free_name([j.name for j in spec.joints], joint.name + ROTOR)
    body = spec.worldbody.add_body(name=free_name([b.name for b in spec.bodies], name))
    body.explicitinertial, body.mass, body.inertia = True, _WEIGHTLESS, [_WEIGHTLESS] * 3
    rotor = body.add_joint(name=name, type=joint.type, ref=joint.ref, springref=joint.ref, armature=inertia)
    rotor.limited = rotor.actfrclimited = _NO_LIMIT
    rotor.damping, rotor.stiffness, rotor.frictionloss = [0.0] * 3, [0.0] * 3, 0.0
    rotor.springdamper = [0.0, 0.0]
    return rotor


ROTOR = "_rotor"
"""Added to a joint's name gives its rotor's."""
_HIDDEN = 4
"""Group of what viewers do not show at first."""
_WEIGHTLESS = 1e-9
"""Mass, kg, and inertia, kg m2, of what has none; MuJoCo wants some."""


def free_name(taken: Sequence[str], wanted: str) -> str:
    """A name that no other element has: the wanted one, or with a number behind it."""
    name, count = wanted, 1
    while name in taken:
        count += 1
        name = f"{wanted}_{count}"
    return name


def _filled(values: Sequence[float]) -> list[float]:
    """Ten numbers, as actuators have them."""
    return [*values, *[0.0] * (10 - len(values))]
