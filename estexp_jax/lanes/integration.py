"""Configurations moved along velocities, a floating base by the rotation of its spin.

Source: MuJoCo documentation, "Computation": "Numerical integration"; Munthe-Kaas, BIT Numerical Mathematics 38 (1998).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import jax
import jax.numpy as jnp

from estexp_jax.lanes.algebra import Scalar, cross, dot
from estexp_jax.lanes.layout import Layout


def moved(layout: Layout, qpos: Any, speed: Sequence[Scalar], dt: Scalar) -> tuple[tuple[Any, ...], ...]:
    """Configurations after `dt` at constant velocities.

    Args:
        layout: structure.
        qpos: per joint, as in `LaneState`.
        speed: per degree of freedom, a floating base's spin in its own axes.
        dt: s.
    """
    return tuple(
        _floated(q, speed[j.dofs[0] : j.dofs[0] + 6], dt) if j.free else (q[0] + dt * speed[j.dofs[0]],)
        for j, q in zip(layout.joints, qpos, strict=True)
    )


def speed_since_start(
    layout: Layout, turning: Sequence[Scalar], speed: Sequence[Scalar], dt: Scalar
) -> tuple[Scalar, ...]:
    """Velocities with a floating base's spin as the rate at which its rotation since the step began changes.

    Args:
        layout: structure.
        turning: velocities that, for `dt`, make up that rotation.
        speed: velocities after it.
        dt: s.
    """
    found = list(speed)
    for joint in layout.joints:
        if joint.free:
            spin = slice(joint.dofs[0] + 3, joint.dofs[0] + 6)
            found[spin] = _rate_of_turn(tuple(dt * v for v in turning[spin]), speed[spin])
    return tuple(found)


def _rate_of_turn(turn: Sequence[Scalar], spin: Sequence[Scalar]) -> list[Scalar]:
    """Rate of a turn (rotation vector, own axes) under a spin: the inverse derivative of the exponential."""
    once = cross(turn, spin)
    twice, square = cross(turn, once), dot(turn, turn)
    third = 1 / 12 + square * (1 / 720 + square * (1 / 30240 + square / 1209600))
    return [a + 0.5 * b + third * c for a, b, c in zip(spin, once, twice, strict=True)]


def _floated(q: Sequence[Scalar], speed: Sequence[Scalar], dt: Scalar) -> tuple[Scalar, ...]:
    """A floating base after `dt` at this speed, its spin in its own axes."""
    w, x, y, z = q[3:]
    spin = jnp.sqrt(dot(speed[3:], speed[3:]) + 1e-30)
    half = 0.5 * dt * spin
    c, s = jnp.cos(half), jnp.sin(half) / spin
    a, b, d = (s * v for v in speed[3:])
    turned = (
        w * c - x * a - y * b - z * d,
        w * a + x * c + y * d - z * b,
        w * b - x * d + y * c + z * a,
        w * d + x * b - y * a + z * c,
    )
    size = jax.lax.rsqrt(dot(turned, turned))
    return tuple(p + dt * v for p, v in zip(q[:3], speed[:3], strict=True)) + tuple(t * size for t in turned)
