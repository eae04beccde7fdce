"""Orientations of bodies as quaternions, multiplied from the root on so that their sign is MuJoCo's."""

from __future__ import annotations

from collections.abc import Sequence

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.algebra import Scalar, add, dot, member_of, mul, sub
from estexp_jax.lanes.layout import Layout
from estexp_jax.lanes.model_parameters import ModelParameters, world_pose

Quaternion = Sequence[Scalar]
"""Four scalars, w first."""


def attitude(layout: Layout, params: ModelParameters, qpos: Sequence[Sequence[Scalar]], body: int) -> Quaternion:
    """Quaternion of a body frame.

    Args:
        layout: structure.
        params: of the robots.
        qpos: per joint of `layout_of.joints`: seven scalars for a floating base, else one.
        body: MuJoCo's index.
    """
    model = layout.model
    if model.body_weldid[body] == 0:
        _, still = world_pose(model, body, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
        return tuple(float(x) for x in still)
    joints = range(int(model.body_jntadr[body]), int(model.body_jntadr[body]) + int(model.body_jntnum[body]))
    slots = {joint: (slot, own.ids.index(joint)) for slot, own in enumerate(layout.joints) for joint in own.ids}
    if joints and int(model.jnt_type[joints[0]]) == int(mujoco.mjtJoint.mjJNT_FREE):
        slot, member = slots[joints[0]]
        floating = [member_of(q, member) for q in qpos[slot][3:]]
        size = jax.lax.rsqrt(dot(floating, floating))
        return tuple(mul(size, q) for q in floating)
    above = attitude(layout, params, qpos, int(model.body_parentid[body]))
    found = quaternion_product(above, quaternion(params, "body_quat", body))
    for joint in joints:
        if int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_HINGE):
            slot, member = slots[joint]
            home = params.get("qpos0", [int(model.jnt_qposadr[joint])])
            half = mul(0.5, sub(member_of(qpos[slot][0], member), home))
            axis = params.vector("jnt_axis", [joint])
            found = quaternion_product(found, (jnp.cos(half), *(mul(x, jnp.sin(half)) for x in axis)))
    return found


def quaternion(params: ModelParameters, field: str, index: int) -> Quaternion:
    """A quaternion of the model."""
    return tuple(params.get(field, [index], i) for i in range(4))


def quaternion_product(a: Quaternion, b: Quaternion) -> Quaternion:
    """First the turn b, then a."""
    (p, q, r, s), (w, x, y, z) = a, b
    return (
        sub(sub(mul(p, w), mul(q, x)), add(mul(r, y), mul(s, z))),
        add(add(mul(p, x), mul(q, w)), sub(mul(r, z), mul(s, y))),
        add(sub(mul(p, y), mul(q, z)), add(mul(r, w), mul(s, x))),
        add(add(mul(p, z), mul(q, y)), sub(mul(s, w), mul(r, x))),
    )
