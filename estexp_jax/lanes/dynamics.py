"""Mass matrix and bias forces: composite bodies, one pass from the leaves to the roots.

Source: Featherstone 2008, sections 5.3 (recursive Newton-Euler) and 6.2 (composite rigid bodies).
"""

from __future__ import annotations

from typing import final

from estexp_jax.lanes.algebra import (
    Scalar,
    Symmetric,
    Vector,
    add,
    all_to_children,
    apply,
    cross,
    dot,
    is_number,
    parallel_axis,
    scale,
    sum_over_children,
    symmetric_apply,
    symmetric_rotated,
    vadd,
)
from estexp_jax.lanes.kinematics import BodyMotion, shift_origin
from estexp_jax.lanes.layout import Group, Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.sparse import Entries


@final
class Inertias:
    """Each group's mass and its inertia about the centre of mass, in the axes of the body: once a rollout."""

    def __init__(self, layout: Layout, params: ModelParameters) -> None:
        """Take them from the numbers."""
        self.mass: list[Scalar] = []
        self.centre: list[Vector] = []
        self.inertia: list[Symmetric] = []
        for group in layout.groups:
            self.mass.append(params.get("body_mass", group.bodies))
            self.centre.append(params.vector("body_ipos", group.bodies))
            turned = params.rotation("body_iquat", group.bodies)
            principal = params.vector("body_inertia", group.bodies)
            self.inertia.append(symmetric_rotated(turned, (*principal, 0, 0, 0)))


def mass_and_bias(
    layout: Layout, params: ModelParameters, inertias: Inertias, moving: BodyMotion
) -> tuple[Entries, list[Scalar]]:
    """The mass matrix, armature included, and the force that zero accelerations need."""
    matrix: Entries = {}
    bias: list[Scalar] = [0] * len(layout.dofs)
    composite = composites(layout, inertias, moving)
    for group in reversed(layout.groups):
        whole = composite[group.index]
        mass, first, second, force, torque = whole[0], whole[1:4], whole[4:10], whole[10:13], whole[13:16]
        for joint in group.joints:
            for i in joint.dofs:
                linear, angular = moving.linear[i], moving.angular[i]
                push = vadd(scale(mass, linear), cross(angular, first))
                twist = vadd(cross(first, linear), symmetric_apply(second, angular))
                for j in (*layout.dofs[i].above, i):
                    above = [all_to_children(m[j], layout.dofs[j].k, group.k) for m in (moving.linear, moving.angular)]
                    matrix[i, j] = add(dot(above[0], push), dot(above[1], twist))
                matrix[i, i] = add(matrix[i, i], params.get("dof_armature", layout.dofs[i].addresses))
                bias[i] = add(dot(linear, force), dot(angular, torque))
    return matrix, bias


def composites(layout: Layout, inertias: Inertias, moving: BodyMotion) -> list[list[Scalar]]:
    """Of each group, its bodies with all that hangs from them: 16 scalars as `_single` has them of one body."""
    composite = [_single(group, inertias, moving) for group in layout.groups]
    for group in reversed(layout.groups):
        whole = composite[group.index]
        for child in layout.children[group.index]:
            whole = [
                add(a, sum_over_children(b, child.k, group.k))
                for a, b in zip(whole, composite[child.index], strict=True)
            ]
        composite[group.index] = whole
    return composite


def _single(group: Group, inertias: Inertias, moving: BodyMotion) -> list[Scalar]:
    """One body: mass, first and second moment about the origin, force and moment its acceleration needs."""
    pose, mass = moving.poses[group.index], inertias.mass[group.index]
    if is_number(mass, 0):
        return [0] * 16
    arm = apply(pose.rotation, inertias.centre[group.index])
    centre = shift_origin(pose, arm)
    inertia = symmetric_rotated(pose.rotation, inertias.inertia[group.index])
    force = scale(mass, centre.acceleration)
    spinning = symmetric_apply(inertia, pose.spin)
    torque = vadd(symmetric_apply(inertia, pose.spin_rate), cross(pose.spin, spinning))
    second = parallel_axis(inertia, mass, centre.position)
    return [mass, *scale(mass, centre.position), *second, *force, *vadd(torque, cross(centre.position, force))]
