"""Friction written into descriptions: bristles as those of a DC motor without windings, beside MuJoCo's friction loss.

Source: MuJoCo documentation, XML reference, actuator/dcmotor: lugre.
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco

from estexp_jax.physics.effects.new_elements import CONSTANT, add_passive_motor
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot, spec_element

_HELD = {int(mujoco.mjtIntegrator.mjINT_EULER): 1.0}
"""Steps over which bristles' force is carried on at the joint's speed, by integrator; by others half a step. Without,
the force is that of the step before, and a joint that sticks swings on."""
_OTHERWISE_HELD = 0.5
_ABOVE = 0.1
"""Share of a fall of friction that its bristles keep at speed: MuJoCo's need a level above 0."""
_WAY, _STIFFEST = 5e-4, 0.2
"""Presliding way (rad or m) of friction that has none, and largest stiffness as a share of what an explicit step
bears."""


def add_bristles(robot: Robot, spec: mujoco.MjSpec, joint: str, stiffness: float, levels: Sequence[float]) -> None:
    """Let a joint be held by bristles.

    Args:
        robot: the nominal robot.
        spec: its description.
        joint: the joint's name.
        stiffness: N m/rad or N/m.
        levels: friction at speed, at rest (N m or N), and the speed between them, rad/s or m/s.
    """
    ahead = _HELD.get(int(spec.option.integrator), _OTHERWISE_HELD) * float(spec.option.timestep)
    spec_element(spec, robot, "joint", joint)
    add_passive_motor(spec, f"{joint}_bristles", joint, lugre=(stiffness, ahead * stiffness, *levels))


def add_falling_friction(
    robot: Robot, spec: mujoco.MjSpec, joint: str, least: float, fall: float, speed: float
) -> None:
    """Let a joint's friction be `least` at speed, more by `fall` at rest: a friction loss, and bristles for the fall.

    Args:
        robot: the nominal robot.
        spec: its description.
        joint: the joint's name.
        least: N m or N.
        fall: N m or N.
        speed: at which it falls, rad/s or m/s.
    """
    kept = min(_ABOVE * fall, least)
    spec_element(spec, robot, "joint", joint).frictionloss += least - kept
    if fall <= 0.0:
        return
    most = _STIFFEST * scales.joint_inertia(robot, robot.index("joint", joint)) / float(spec.option.timestep) ** 2
    stiffness = min((kept + fall) / _WAY, most)
    levels = (max(kept, 1e-3 * fall), kept + fall, speed)
    add_passive_motor(spec, f"{joint}_stribeck", joint, lugre=(stiffness, 0.0, *levels))


def add_dry_friction(robot: Robot, spec: mujoco.MjSpec, joint: str, size: float, asymmetry: float) -> None:
    """Let a joint be resisted by T (1 + a sign(w)) sign(w) = T sign(w) + a T: a friction loss, and a constant torque.

    At rest the two hold against as much either way.
    """
    spec_element(spec, robot, "joint", joint).frictionloss += size
    if asymmetry:
        add_passive_motor(spec, f"{joint}_asymmetry", joint, cogging=(-asymmetry * size, *CONSTANT))
