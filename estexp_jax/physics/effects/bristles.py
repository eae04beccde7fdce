"""Dry friction as bristles: it builds up over a short way, and holds like a spring until then.

dF/dq = (F_s sign(w) - F) / x with the level F_s of steady sliding and the presliding way x. Where the level is constant
this is Dahl's friction of stiffness F_s / x; a level that depends on speed makes it LuGre's, without its damping.

Source: Canudas de Wit, Olsson, Astrom and Lischinsky, IEEE Transactions on Automatic Control 40 (1995).
"""

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Array, Arrays, JointForce, JointState


def bristle_at_rest(q: Array) -> Arrays:
    """The state of relaxed bristles."""
    return jnp.zeros_like(q), q


def bristle_friction(level: Array, way: Array, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
    """What bristles do for one step, and their state.

    Since the last step the joint moved by dq, over which the law has the exact solution
    F' = F_s s + (F - F_s s) exp(-|dq| / x), s = sign(dq). The step ahead takes F linearised about the present speed,
    with its slope as implicit damping, so that stiff bristles do not chatter.

    Args:
        level: F_s, N m or N.
        way: x, rad or m.
        joint: of the joint.
        state: the force, and the position a step ago.
    """
    (force, q_before), (w, dt) = state, (joint.w, joint.dt)
    force = _after_displacement(level, way, force, joint.q - q_before)
    ahead = _after_displacement(level, way, force, w * dt)
    slope = dt / way * jnp.maximum(level - ahead * jnp.sign(w), 0.0)
    return JointForce(force=slope * w - ahead, damping=slope), (force, joint.q)


def _after_displacement(level: Array, way: Array, force: Array, moved: Array) -> Array:
    """The force after a displacement in one direction."""
    end = level * jnp.sign(moved)
    return end + (force - end) * jnp.exp(-jnp.abs(moved) / way)
