"""Poses, velocities and force-free accelerations of bodies: one pass from the roots to the leaves.

Everything is in world axes about the origin of the tree: the floating base, or the world where the base is fixed. The
accelerations are those of zero joint accelerations, with gravity as an acceleration of the base (Featherstone 2008,
section 5.3).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import final

import jax.numpy as jnp
import mujoco

from estexp_jax.lanes.algebra import (
    ZERO,
    Matrix,
    Scalar,
    Vector,
    all_to_children,
    apply,
    compose,
    cross,
    from_quaternion,
    is_number,
    rotation_about,
    scale,
    sub,
    vadd,
)
from estexp_jax.lanes.layout import Group, Joint, Layout
from estexp_jax.lanes.model_parameters import ModelParameters, world_pose


@final
@dataclass
class Pose:
    """A group's bodies.

    Attributes:
        rotation, position: of the body frame.
        spin, spin_rate: angular velocity and its rate of change.
        acceleration: of the body frame's origin.
        velocity: of the body frame's origin.
    """

    rotation: Matrix
    position: Vector
    spin: Vector
    spin_rate: Vector
    acceleration: Vector
    velocity: Vector


@final
@dataclass
class BodyMotion:
    """Results of the pass from the roots.

    Attributes:
        poses: of each group.
        origin: of each group's tree, world coordinates.
        linear, angular: of each degree of freedom, the velocity of the origin and the spin that unit speed gives.
        speed: of each degree of freedom; a floating base's spin in world axes.
        base: rotation of each floating base, by its first degree of freedom.
    """

    poses: list[Pose] = field(default_factory=list)
    origin: list[Vector] = field(default_factory=list)
    linear: dict[int, Vector] = field(default_factory=dict)
    angular: dict[int, Vector] = field(default_factory=dict)
    speed: list[Scalar] = field(default_factory=list)
    base: dict[int, Matrix] = field(default_factory=dict)


def body_motion(
    layout: Layout, params: ModelParameters, qpos: Sequence[Sequence[Scalar]], qvel: Sequence[Scalar]
) -> BodyMotion:
    """Poses and velocities.

    Args:
        layout: structure.
        params: of the robots.
        qpos: per joint of `layout_of.joints`: seven scalars for a floating base, else one.
        qvel: per degree of freedom; a floating base's spin in its own axes, as in MuJoCo.
    """
    found = BodyMotion(speed=list(qvel))
    coordinates = iter(qpos)
    for group in layout.groups:
        pose, origin = _before_joints(layout, params, group, found)
        for joint in group.joints:
            q = next(coordinates)
            if joint.free:
                pose, origin = _float(joint, q, params, found)
            elif joint.hinge:
                pose = _hinge(joint, q[0], pose, params, found)
            else:
                pose = _slide(joint, q[0], pose, params, found)
        found.poses.append(pose)
        found.origin.append(origin)
    return found


def _before_joints(layout: Layout, params: ModelParameters, group: Group, found: BodyMotion) -> tuple[Pose, Vector]:
    if group.parent is None:
        rotation, place = _on_world(layout.model, params, group.bodies)
        return Pose(rotation, place, ZERO, ZERO, scale(-1, params.gravity()), ZERO), ZERO
    parent, k_from, k = found.poses[group.parent], layout.groups[group.parent].k, group.k
    rotation = tuple(all_to_children(row, k_from, k) for row in parent.rotation)
    spin, rate, position, acceleration, velocity = (
        all_to_children(v, k_from, k)
        for v in (parent.spin, parent.spin_rate, parent.position, parent.acceleration, parent.velocity)
    )
    arm = apply(rotation, params.vector("body_pos", group.bodies))
    pose = Pose(rotation, position, spin, rate, acceleration, velocity)
    _move(pose, arm)
    pose.rotation = compose(rotation, params.rotation("body_quat", group.bodies))
    return pose, tuple(all_to_children(found.origin[group.parent], k_from, k))


def _on_world(model: mujoco.MjModel, params: ModelParameters, bodies: Sequence[int]) -> tuple[Matrix, Vector]:
    """Pose of a body that hangs from the world, maybe by others that cannot move, without its joints."""
    if model.body_parentid[bodies[0]] == 0:
        return params.rotation("body_quat", bodies), params.vector("body_pos", bodies)
    body = int(bodies[0])
    position, quaternion = world_pose(
        model, int(model.body_parentid[body]), model.body_pos[body], model.body_quat[body]
    )
    return params.known_rotation(quaternion[None]), params.known_vector(position[None])


def _move(pose: Pose, arm: Vector) -> None:
    """Go to another point of the same rigid body."""
    if all(is_number(x, 0) for x in arm):
        return
    centripetal = cross(pose.spin, cross(pose.spin, arm))
    pose.position = vadd(pose.position, arm)
    pose.acceleration = vadd(pose.acceleration, vadd(cross(pose.spin_rate, arm), centripetal))
    pose.velocity = vadd(pose.velocity, cross(pose.spin, arm))


def _float(joint: Joint, q: Sequence[Scalar], params: ModelParameters, found: BodyMotion) -> tuple[Pose, Vector]:
    first = joint.dofs[0]
    rotation = from_quaternion(*q[3:])
    found.base[first] = rotation
    spin = apply(rotation, found.speed[first + 3 : first + 6])
    found.speed[first + 3 : first + 6] = spin
    for e in range(3):
        unit = tuple(int(e == i) for i in range(3))
        found.linear[first + e], found.angular[first + e] = unit, ZERO
        found.linear[first + 3 + e], found.angular[first + 3 + e] = ZERO, unit
    velocity = tuple(found.speed[first : first + 3])
    return Pose(rotation, ZERO, spin, ZERO, scale(-1, params.gravity()), velocity), tuple(q[:3])


def _hinge(joint: Joint, q: Scalar, pose: Pose, params: ModelParameters, found: BodyMotion) -> Pose:
    dof, speed = joint.dofs[0], found.speed[joint.dofs[0]]
    local, anchor = params.vector("jnt_axis", joint.ids), params.vector("jnt_pos", joint.ids)
    axis = apply(pose.rotation, local)
    _move(pose, apply(pose.rotation, anchor))
    found.linear[dof], found.angular[dof] = cross(pose.position, axis), axis
    angle = sub(q, params.get("qpos0", joint.qpos))
    rotation = compose(pose.rotation, rotation_about(local, jnp.sin(angle), jnp.cos(angle)))
    turning = scale(speed, axis)
    pose.spin_rate = vadd(pose.spin_rate, cross(pose.spin, turning))
    pose.spin = vadd(pose.spin, turning)
    pose.rotation = rotation
    _move(pose, scale(-1, apply(rotation, anchor)))
    return pose


def _slide(joint: Joint, q: Scalar, pose: Pose, params: ModelParameters, found: BodyMotion) -> Pose:
    dof, speed = joint.dofs[0], found.speed[joint.dofs[0]]
    axis = apply(pose.rotation, params.vector("jnt_axis", joint.ids))
    _move(pose, scale(sub(q, params.get("qpos0", joint.qpos)), axis))
    pose.acceleration = vadd(pose.acceleration, scale(2 * speed, cross(pose.spin, axis)))
    pose.velocity = vadd(pose.velocity, scale(speed, axis))
    found.linear[dof], found.angular[dof] = axis, ZERO
    return pose


def shift_origin(pose: Pose, arm: Vector) -> Pose:
    """The same body at another of its points, `arm` (world axes) away."""
    other = Pose(pose.rotation, pose.position, pose.spin, pose.spin_rate, pose.acceleration, pose.velocity)
    _move(other, arm)
    return other
