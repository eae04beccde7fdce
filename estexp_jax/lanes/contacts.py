"""From poses to contact rows: how deep each candidate point is in its plane, and along which axes it pushes.

Source: MuJoCo `engine_collision_primitive.c` (plane against sphere, capsule, box), `engine_core_constraint.c`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.algebra import (
    Scalar,
    Vector,
    add,
    all_to_children,
    apply,
    cross,
    dot,
    is_number,
    maximum,
    mul,
    scale,
    sub,
    to_children,
    total,
    vadd,
    vsub,
)
from estexp_jax.lanes.contact_candidates import Candidate, mixed
from estexp_jax.lanes.kinematics import BodyMotion
from estexp_jax.lanes.layout import Group, Layout
from estexp_jax.lanes.model_parameters import ModelParameters, rotation_matrix, world_pose
from estexp_jax.lanes.rows import ContactPush, Pyramid, Residual
from estexp_jax.lanes.softness import Softness, regularised

_GEOM = mujoco.mjtGeom


@final
@dataclass(frozen=True, eq=False)
class Contact:
    """Alike points and what they push with.

    Attributes:
        group: index of their bodies' group.
        candidate: which points.
        rows: their constraints.
        position: of the contact, about the tree's origin.
        normal: away from the plane.
    """

    group: int
    candidate: Candidate
    rows: Pyramid | ContactPush
    position: Vector
    normal: Vector

    def normal_force(self, r: Residual) -> Scalar:
        """(k, N), N, of the constraints' residual."""
        return self.rows.forces(r)[2] if isinstance(self.rows, Pyramid) else self.rows.forces(r)


def contacts(layout: Layout, params: ModelParameters, moving: BodyMotion, dt: Scalar) -> list[Contact]:
    """All contacts; those that do not touch have no stiffness."""
    return [
        _contact(layout, params, moving, group, candidate, dt) for group in layout.groups for candidate in group.touches
    ]


def _contact(
    layout: Layout, params: ModelParameters, moving: BodyMotion, group: Group, candidate: Candidate, dt: Scalar
) -> Contact:
    model, k = layout.model, candidate.k
    place, normal = _plane(model, params, candidate.plane)
    point, radius, along, upper = _point(params, moving, group, candidate, normal)
    height = sub(dot(normal, vadd(point, all_to_children(moving.origin[group.index], group.k, k))), dot(normal, place))
    distance = sub(height, radius)
    position = vsub(point, scale(radius + 0.5 * distance, normal))
    margin = add(params.get("geom_margin", candidate.geoms), params.get("geom_margin", [candidate.plane] * candidate.k))
    violation = sub(distance, margin)
    active = violation < 0
    if upper is not None:
        active = active & (upper <= 0)
    soft = _softness(params, candidate)
    impedance = soft.impedance(violation)
    spring, damper = soft.spring(dt, safe=not model.opt.disableflags & mujoco.mjtDisableBit.mjDSBL_REFSAFE)
    weight = params.get("body_invweight0", _bodies(model, candidate), 0)
    frame = (normal,) if candidate.condim == 1 else (*_tangents(normal, along), normal)
    axes = [
        tuple(dot(axis, velocity) for axis in frame)
        for velocity in (
            vadd(
                all_to_children(moving.linear[i], layout.dofs[i].k, k),
                cross(all_to_children(moving.angular[i], layout.dofs[i].k, k), position),
            )
            for i in group.chain
        )
    ]
    moved = [to_children(moving.speed[i], layout.dofs[i].k, k) for i in group.chain]
    speed = [total(mul(a[e], v) for a, v in zip(axes, moved, strict=True)) for e in range(len(frame))]
    back = -spring * impedance * violation
    if candidate.condim == 1:
        stiffness = jnp.where(active, regularised(weight, impedance), 0.0)
        rows = ContactPush(k, group.chain, tuple(a[0] for a in axes), stiffness, back - damper * speed[0])
        return Contact(group.index, candidate, rows, position, normal)
    friction = _friction(model, params, candidate)
    mu = friction / np.sqrt(model.opt.impratio)
    edge = 2 * mu * mu * (weight + friction * friction * weight)
    stiffness = jnp.where(active, regularised(edge, impedance), 0.0)
    slip = [mul(friction, s) for s in speed[:2]]
    aref = tuple(back - damper * (speed[2] + s) for s in (slip[0], -slip[0], slip[1], -slip[1]))
    rows = Pyramid(k, group.chain, tuple(axes), friction, stiffness, aref)
    return Contact(group.index, candidate, rows, position, normal)


def _bodies(model: mujoco.MjModel, candidate: Candidate) -> Sequence[int]:
    return [int(model.geom_bodyid[g]) for g in candidate.geoms]


def _plane(model: mujoco.MjModel, params: ModelParameters, plane: int) -> tuple[Vector, Vector]:
    """A point of a plane and its normal, world axes."""
    body = int(model.geom_bodyid[plane])
    position, quaternion = world_pose(model, body, model.geom_pos[plane], model.geom_quat[plane])
    normal = rotation_matrix(quaternion)[:, 2]
    return params.known_vector(position[None]), params.known_vector(normal[None])


def _point(
    params: ModelParameters, moving: BodyMotion, group: Group, candidate: Candidate, normal: Vector
) -> tuple[Vector, Scalar, Vector | None, Scalar | None]:
    """The point, the radius around it, a capsule's axis, how far a corner is above its box's centre."""
    pose, k, geoms = moving.poses[group.index], candidate.k, candidate.geoms
    rotation = [all_to_children(row, group.k, k) for row in pose.rotation]
    centre = vadd(all_to_children(pose.position, group.k, k), apply(rotation, params.vector("geom_pos", geoms)))
    if candidate.shape == _GEOM.mjGEOM_SPHERE:
        return centre, params.get("geom_size", geoms, 0), None, None
    turned = params.rotation("geom_quat", geoms)
    side = params.known_vector(np.array(candidate.at, dtype=float))
    if candidate.shape == _GEOM.mjGEOM_CAPSULE:
        axis = apply(rotation, tuple(row[2] for row in turned))
        half = mul(side[2], params.get("geom_size", geoms, 1))
        return vadd(centre, scale(half, axis)), params.get("geom_size", geoms, 0), axis, None
    size = params.vector("geom_size", geoms)
    corner = apply(rotation, apply(turned, tuple(mul(s, x) for s, x in zip(side, size, strict=True))))
    return vadd(centre, corner), 0, None, dot(normal, corner)


def _tangents(normal: Vector, along: Vector | None) -> tuple[Vector, Vector]:
    """MuJoCo's frame: the second axis along a capsule, else the world's y (z if the normal is near y)."""
    if along is None:
        steep = all(isinstance(x, (int, float)) for x in normal) and abs(normal[1]) >= 0.5
        along = (0, 0, 1) if steep else (0, 1, 0)
    flat = vsub(along, scale(dot(along, normal), normal))
    length = dot(flat, flat)
    if not is_number(length, 1):
        flat = scale(jax.lax.rsqrt(maximum(jnp.asarray(length), 1e-30)), flat)
    return flat, cross(normal, flat)


def _softness(params: ModelParameters, candidate: Candidate) -> Softness:
    refs, imps = zip(*(mixed(params.model, candidate.plane, g) for g in candidate.geoms), strict=True)
    return Softness.of(params, np.array(refs), np.array(imps))


def _friction(model: mujoco.MjModel, params: ModelParameters, candidate: Candidate) -> Scalar:
    """Sliding friction: the greater of the two, unless one has priority."""
    own = params.get("geom_friction", candidate.geoms, 0)
    floor = params.get("geom_friction", [candidate.plane] * candidate.k, 0)
    ahead = model.geom_priority[list(candidate.geoms)] - model.geom_priority[candidate.plane]
    if np.all(ahead == 0):
        least = mujoco.mjMINMU
        return maximum(maximum(own, floor), least)
    return own if ahead[0] > 0 else floor
