"""What stands between a motor and its joint, written into descriptions: a rotor beside the joint, tied to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco

from estexp_jax.physics.effects.new_elements import add_rotor, add_tendon
from estexp_jax.physics.model.robot import Robot, spec_element

SOONEST = 2.0
"""Steps of the time constant of MuJoCo's hardest constraint."""
_ENDS = 0.9, 0.95, 1e-4, 0.5, 2.0
"""Impedance of a play's ends: hard from the first."""


def motors_of(robot: Robot, joint: str) -> tuple[int, ...]:
    """Indices of the actuators that drive a joint."""
    index = robot.index("joint", joint)
    return tuple(a for a in range(robot.model.nactuator) if robot.joint_of_actuator(a) == index)


def feeds_back(robot: Robot, actuator: int) -> bool:
    """Whether an actuator's force depends on where its joint is, or how fast."""
    return bool(robot.model.actuator_biasprm[actuator, 1:3].any())


def behind_refusal(robot: Robot, joint: str) -> str:
    """Why motors cannot be put behind a spring or a gap in a loop that sees the joint; empty where they can."""
    if any(feeds_back(robot, a) for a in motors_of(robot, joint)):
        return "the servo's loop sees the joint behind it, and MuJoCo's servos see what they turn"
    return ""


def put_rotor(robot: Robot, spec: mujoco.MjSpec, joint: str, inertia: float) -> Any:
    """Add a rotor beside a joint, and let the joint's motors turn it."""
    rotor = add_rotor(spec, spec_element(spec, robot, "joint", joint), inertia)
    for a in motors_of(robot, joint):
        actuator = spec_element(spec, robot, "actuator", robot.names("actuator")[a])
        if actuator.trntype == mujoco.mjtTrn.mjTRN_JOINT and actuator.target == joint:
            actuator.target = rotor.name
    return rotor


def add_spring_drive(
    robot: Robot, spec: mujoco.MjSpec, joint: str, inertia: float, stiffness: float, damping: float
) -> None:
    """Let the motors of a joint move it through a rotor and a spring with a damper."""
    rotor = put_rotor(robot, spec, joint, inertia)
    tendon = add_tendon(spec, f"{joint}_spring", ((rotor.name, 1.0), (joint, -1.0)))
    tendon.stiffness, tendon.damping = [stiffness, 0.0, 0.0], [damping, 0.0, 0.0]


def add_play(
    robot: Robot, spec: mujoco.MjSpec, joint: str, half_gap: float, inertia: float, rebound: Sequence[float] = ()
) -> None:
    """Let the motors of a joint turn a rotor that meets it at the ends of a gap; its inertia is the joint's armature's.

    Args:
        robot: the nominal robot.
        spec: its description.
        joint: the joint's name.
        half_gap: rad or m.
        inertia: kg m2 or kg, of the rotor.
        rebound: time constant (s) and damping ratio of the ends; without, they are the hardest that do not bounce.
    """
    there = spec_element(spec, robot, "joint", joint)
    there.armature = max(there.armature - inertia, 0.0)
    rotor = put_rotor(robot, spec, joint, inertia)
    tendon = add_tendon(spec, f"{joint}_play", ((rotor.name, 1.0), (joint, -1.0)))
    tendon.limited, tendon.range = mujoco.mjtLimited.mjLIMITED_TRUE, [-half_gap, half_gap]
    tendon.solref_limit = [*rebound] or [SOONEST * float(spec.option.timestep), 1.0]
    tendon.solimp_limit = list(_ENDS)
