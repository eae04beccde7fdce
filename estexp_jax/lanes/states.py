"""States of robots, from MuJoCo's order with the robots first to lanes and back."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import numpy as np

from estexp_jax.lanes.algebra import Scalar, apply, from_quaternion, transposed
from estexp_jax.lanes.layout import Layout
from estexp_jax.lanes.step import LaneState


def to_lanes(layout: Layout, qpos: jax.Array, qvel: jax.Array, warmstart: jax.Array) -> LaneState:
    """Lanes of (nq, N), (nv, N), (nv, N): MuJoCo's states with the robots last."""
    coordinates = tuple(
        tuple(qpos[j.qpos[0] + i] for i in range(7)) if j.free else (_rows(qpos, j.qpos),) for j in layout.joints
    )
    speed = tuple(_rows(qvel, d.addresses) for d in layout.dofs)
    start = [_rows(warmstart, d.addresses) for d in layout.dofs]
    for joint, q in zip(layout.joints, coordinates, strict=True):
        if joint.free:
            first = joint.dofs[0] + 3
            start[first : first + 3] = apply(from_quaternion(*q[3:]), start[first : first + 3])
    return LaneState(coordinates, speed, tuple(start))


def configuration_of(layout: Layout, state: LaneState) -> list[jax.Array]:
    """The configuration, one array (N,) for each of its nq numbers."""
    qpos: list[Scalar] = [None] * layout.model.nq
    for joint, q in zip(layout.joints, state.qpos, strict=True):
        if joint.free:
            qpos[joint.qpos[0] : joint.qpos[0] + 7] = q
        else:
            _put(qpos, joint.qpos, q[0])
    return qpos


def from_lanes(layout: Layout, state: LaneState) -> tuple[jax.Array, jax.Array, jax.Array]:
    """The inverse of `to_lanes`: (nq, N), (nv, N), (nv, N)."""
    qvel: list[Scalar] = [None] * layout.model.nv
    warmstart: list[Scalar] = [None] * layout.model.nv
    start = list(state.warmstart)
    for joint, q in zip(layout.joints, state.qpos, strict=True):
        if joint.free:
            first = joint.dofs[0] + 3
            start[first : first + 3] = apply(transposed(from_quaternion(*q[3:])), start[first : first + 3])
    for dof in layout.dofs:
        _put(qvel, dof.addresses, state.qvel[dof.index])
        _put(warmstart, dof.addresses, start[dof.index])
    return jnp.stack(configuration_of(layout, state)), jnp.stack(qvel), jnp.stack(warmstart)


def _rows(table: jax.Array, members: tuple[int, ...]) -> jax.Array:
    return table[members[0]] if len(members) == 1 else jnp.stack([table[m] for m in members])


def _put(table: list[Scalar], members: tuple[int, ...], x: Scalar) -> None:
    for n, m in enumerate(members):
        table[m] = x[n] if np.ndim(x) == 2 else x
