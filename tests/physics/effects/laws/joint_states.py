"""A joint in many states at once, and the force that a law puts on it there."""

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import JointState
from estexp_jax.physics.effects.laws.base import JointLaw
from estexp_jax.physics.effects.registry import effect

Q, W, M = np.linspace(-1.2, 1.4, 27), np.linspace(-3.0, 3.1, 27), np.linspace(2.0, -2.5, 27)
FASTER = np.cos(2.0 * Q)
"""Acceleration."""
Q2, W2, M2 = np.cos(Q), np.sin(3.0 * W), np.cos(2.0 * W)
ASKED = M + 0.2 * W
"""A servo's demand, of which damping takes some away."""


def joint_state() -> JointState:
    q, w, m = (jnp.asarray(x, jnp.float32) for x in (Q, W, M))
    one = jnp.ones_like(q)

    def motion_of(number):
        there = number > 1.5
        return jnp.where(there, jnp.asarray(Q2), 0.0), jnp.where(there, jnp.asarray(W2), 0.0)

    def torque_of(number):
        return jnp.where(number > 1.5, jnp.asarray(M2), 0.0)

    asked = (jnp.asarray(ASKED - 3.0 * Q, jnp.float32), jnp.asarray(ASKED, jnp.float32))
    return JointState(q, w, m, one, 0.002, one, one, lambda q, w: m, torque_of, motion_of, lambda: asked)


def force(name: str, *p: float, state: tuple = ()) -> np.ndarray:
    """On the joint, with what is implicit taken at the present speed."""
    law = effect(name)
    assert isinstance(law, JointLaw)
    does, _ = law.act(tuple(jnp.full(len(Q), x) for x in p), joint_state(), tuple(jnp.full(len(Q), x) for x in state))
    total = does.force - does.damping * W - does.friction * np.sign(W) - does.inertia * FASTER
    total = total + (does.motor - 1.0) * M + does.command
    return np.asarray(total, float) + np.zeros(len(Q))


REMEMBERING = {
    "law_rhythm": (0.4, 1.5, 0.3),
    "law_creep": (5.0, 0.5),
    "law_thinning": (0.4, 2.0, 0.5),
    "law_warm_motor": (0.6, 0.3, 0.5),
    "law_late_command": (0.7, 0.05),
    "law_bristles": (0.4, 0.02),
}
"""Laws with hidden variables, and values of theirs."""
