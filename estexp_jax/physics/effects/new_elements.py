"""Elements of MuJoCo's own that are added to a description: they take nothing over from the model's defaults.

What is added stands after what is there and drives no command, so that addresses of states, commands and readings
stay as they are.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any
from xml.etree import ElementTree

import mujoco
import numpy as np

from estexp_jax.physics.model.actuators import HAS_DECLARED_INPUTS, NO_INPUT

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

    Raises:
        NotImplementedError: MuJoCo before 4, where every motor has a command.

    Source: MuJoCo documentation, XML reference, actuator/dcmotor.
    """
    if not HAS_DECLARED_INPUTS:
        raise NotImplementedError("MuJoCo has motors without a command since version 4")
    motor = spec.add_actuator(name=free_name([a.name for a in spec.actuators], name))
    motor.trntype, motor.target = mujoco.mjtTrn.mjTRN_JOINT, joint
    motor.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    motor.ctrllimited = motor.forcelimited = motor.actlimited = _NO_LIMIT
    motor.delay, motor.nsample, motor.damping, motor.armature = 0.0, 0, [0.0, 0.0, 0.0], 0.0
    motor.dyntype, motor.gaintype = mujoco.mjtDyn.mjDYN_DCMOTOR, mujoco.mjtGain.mjGAIN_DCMOTOR
    motor.biastype, motor.ctrlspec = mujoco.mjtBias.mjBIAS_DCMOTOR, NO_INPUT
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
    tendon.range = [0.0, 0.0]
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
    body.ipos = [0.0, 0.0, 0.0]
    body.explicitinertial, body.mass, body.inertia = True, _WEIGHTLESS, [_WEIGHTLESS] * 3
    rotor = body.add_joint(name=name, type=joint.type, ref=joint.ref, springref=joint.ref, armature=inertia)
    rotor.limited = rotor.actfrclimited = _NO_LIMIT
    rotor.damping, rotor.stiffness, rotor.frictionloss = [0.0] * 3, [0.0] * 3, 0.0
    rotor.springdamper = rotor.range = [0.0, 0.0]
    return rotor


ROTOR = "_rotor"
"""Added to a joint's name gives its rotor's."""
_PASSIVE = ("name", "class", "joint", "tendon", "site", "refsite", "gear", "group")
"""What is said of a passive motor beside its magnets and bearings."""
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


def passive_motor_text(element: ElementTree.Element) -> ElementTree.Element:
    """A motor without windings as authors write it, of the general actuator that MuJoCo writes; others as they are."""
    a = dict(element.attrib)
    if (a.get("dyntype"), a.get("input")) != ("dcmotor", "none"):
        return element
    bias, dynamics = ([float(x) for x in a.get(name, "").split()] + [0.0] * 10 for name in ("biasprm", "dynprm"))
    a = {name: a[name] for name in _PASSIVE if name in a} | {"input": "none", "motorconst": "0", "resistance": "1"}
    a |= {"cogging": _as_text(bias[:3])} if any(bias[:3]) else {}
    a |= {"lugre": _as_text([*dynamics[5:7], *bias[3:6]])} if any(dynamics[5:7]) else {}
    return ElementTree.Element("dcmotor", a)


def _as_text(values: Iterable[float]) -> str:
    return " ".join(repr(x) if x % 1.0 else f"{x:g}" for x in values)
