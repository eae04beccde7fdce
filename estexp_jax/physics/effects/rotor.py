"""A rotor that its motor turns, one implicit step: what stands behind springs and gaps."""

from __future__ import annotations

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Array, JointState
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_NUDGE = 1e-3
"""Displacement (rad, rad/s) over which a motor's torque is derived."""
_LEAST_INERTIA = 1e-7


def rotor_step(
    joint: JointState,
    r: Array,
    a: Array,
    h: Array,
    inertia: Array,
    spring: tuple[Array, Array] = (0.0, 0.0),
    damper: tuple[Array, Array] = (0.0, 0.0),
) -> tuple[Array, Array, Array]:
    """One linearly implicit Euler step of I da/dt = T(r, a) - k (r - q) - d (a - w), dr/dt = a.

    With T_r, T_a <= 0 the motor's slopes: (I - h T_a + h d + h^2 (k - T_r)) a' = I a + h (T - T_a a - k (r - q) + d w).

    Args:
        joint: gives the motor's torque T.
        r: position of the rotor.
        a: its speed.
        h: length of the step, s.
        inertia: I.
        spring: k, and the position q of its other end after the step.
        damper: d, and the speed w of its other end.

    Returns:
        Position and speed after the step, and T_a.
    """
    (k, q), (d, w) = spring, damper
    inertia = jnp.maximum(inertia, _LEAST_INERTIA)
    torque = joint.torque_at(r, a)
    by_place = jnp.minimum(joint.torque_at(r + _NUDGE, a) - torque, 0.0) / _NUDGE
    by_speed = jnp.minimum(joint.torque_at(r, a + _NUDGE) - torque, 0.0) / _NUDGE
    drive = inertia * a + h * (torque - by_speed * a - k * (r - q) + d * w)
    after = drive / (inertia - h * by_speed + h * d + h**2 * (k - by_place))
    return r + h * after, after, by_speed


def holding_force(joint: JointState) -> JointState:
    """The same joint with a motor whose own loop sees the joint: where its rotor is does not change its torque."""
    return joint._replace(torque_at=lambda r, a: joint.torque)


def inertia_bounds(robot: Robot, site: str) -> tuple[float, float]:
    """Plausible (low, high) inertia of a rotor behind a gap: part of the joint's armature, its own where that is 0."""
    joint = robot.index("joint", site)
    inertia, address = scales.joint_inertia(robot, joint), robot.model.jnt_dofadr[joint]
    armature = float(robot.model.dof_armature[address])
    return (0.5 * armature, armature) if armature > 0.0 else (0.01 * inertia, inertia)
