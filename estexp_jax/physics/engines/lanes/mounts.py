"""Bodies that a model welds and that may give, in lanes: what they carry, and how it moves about their origins."""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.algebra import (
    Scalar,
    Vector,
    add,
    cross,
    member_of,
    members_of,
    mul,
    scale,
    sub,
    sum_over_children,
    symmetric_apply,
    vadd,
)
from estexp_jax.lanes.dynamics import Inertias, composites
from estexp_jax.lanes.kinematics import body_motion
from estexp_jax.lanes.layout import Layout
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.step import LaneState
from estexp_jax.physics.effects.mounts import MountState
from estexp_jax.physics.model.robot import Robot


def mount_states_in_lanes(
    robot: Robot,
    layout: Layout,
    params: ModelParameters,
    state: LaneState,
    bodies: np.ndarray,
    dofs: np.ndarray,
) -> MountState:
    """Bodies (n,) that may give, each with one degree of freedom (n,) that it carries; rows (n, N).

    Args:
        robot: the nominal robot.
        layout: structure.
        params: of the robots.
        state: of the robots.
        bodies: indices.
        dofs: velocity addresses.
    """
    moving = body_motion(layout, params, state.qpos, state.qvel)
    composite = composites(layout, Inertias(layout, params), moving)
    each = _momenta(layout, composite, moving)
    zero = jnp.zeros_like(member_of(state.qvel[0], 0))
    own = {int(b): _mount(robot, layout, composite, each, int(b)) for b in dict.fromkeys(bodies.tolist())}
    found = []
    for b, d in zip(bodies.tolist(), dofs.tolist(), strict=True):
        origin, whole = own[b]
        angular, linear, _ = each[d]
        found.append((_shifted_to(origin, angular, linear), linear, *whole, params.gravity()))

    def rows(vectors: Any) -> tuple[Any, ...]:
        return tuple(jnp.stack([x + zero for x in column]) for column in zip(*vectors, strict=True))

    return MountState(*(rows(vectors) for vectors in zip(*found, strict=True)))


def _mount(robot: Robot, layout: Layout, composite: Any, each: Any, body: int) -> tuple[tuple[float, ...], Any]:
    """Origin of a body that may give; momentum, inertia and first moment as `MountState` has them."""
    carried = set(robot.subtree(body))
    held, origin = _held(robot, body)
    whole: list[Scalar] = list(held)
    for group in layout.groups:
        if group.parent is None and group.bodies[0] in carried:
            more = [sum_over_children(x, group.k, 1) for x in composite[group.index][: len(whole)]]
            whole = [add(a, b) for a, b in zip(whole, more, strict=True)]
    turning, moving = (0, 0, 0), (0, 0, 0)
    for d, (n, f, speed) in each.items():
        if int(robot.model.dof_bodyid[d]) in carried:
            turning, moving = vadd(turning, scale(speed, n)), vadd(moving, scale(speed, f))
    mass, first = whole[0], whole[1:4]
    shifted = vadd(first, scale(-1, scale(mass, origin)))
    return origin, (_shifted_to(origin, turning, moving), _inertia_about(origin, whole, shifted), shifted)


def _inertia_about(origin: Vector, whole: list[Scalar], shifted: Vector) -> list[Scalar]:
    """Inertia about a point, of one about the world's origin: minus the symmetric parts of origin and first moment."""
    first = whole[1:4]
    dots = [add(mul(o, f), mul(o, s)) for o, f, s in zip(origin, first, shifted, strict=True)]
    crossed = [add(mul(origin[i], shifted[j]), mul(first[i], origin[j])) for i, j in ((0, 1), (0, 2), (1, 2))]
    xx, yy, zz, xy, xz, yz = whole[4:10]
    x, y, z = dots
    diagonal = [sub(xx, add(y, z)), sub(yy, add(x, z)), sub(zz, add(x, y))]
    return [*diagonal, *(add(a, b) for a, b in zip((xy, xz, yz), crossed, strict=True))]


def _momenta(layout: Layout, composite: Any, moving: Any) -> dict[int, tuple[Vector, Vector, Scalar]]:
    """Angular and linear momentum that unit speed of each degree of freedom gives, and its speed, by its address."""
    found = {}
    for group in layout.groups:
        for joint in group.joints:
            for i in joint.dofs:
                n, f = _momentum(composite[group.index], moving.angular[i], moving.linear[i])
                for k, address in enumerate(layout.dofs[i].addresses):
                    found[address] = members_of(n, k), members_of(f, k), member_of(moving.speed[i], k)
    return found


def _momentum(whole: Any, spin: Vector, speed: Vector) -> tuple[Vector, Vector]:
    """Angular momentum about the world's origin and linear one, of what turns and has this speed there."""
    mass, first, second = whole[0], whole[1:4], whole[4:10]
    return vadd(cross(first, speed), symmetric_apply(second, spin)), vadd(scale(mass, speed), cross(spin, first))


def _shifted_to(origin: Vector, angular: Vector, linear: Vector) -> Vector:
    return vadd(angular, scale(-1, cross(origin, linear)))


def _held(robot: Robot, body: int) -> tuple[list[float], tuple[float, ...]]:
    """Mass, first and second moment about the world's origin of a body and all that is welded to it; its origin."""
    model, data = robot.model, mujoco.MjData(robot.model)
    mujoco.mj_kinematics(model, data)
    mass, first, second = 0.0, np.zeros(3), np.zeros((3, 3))
    for b in robot.subtree(body):
        if model.body_weldid[b] == 0:
            axes, at, m = data.ximat[b].reshape(3, 3), data.xipos[b], float(model.body_mass[b])
            mass, first = mass + m, first + m * at
            second += axes @ np.diag(model.body_inertia[b]) @ axes.T + m * (at @ at * np.eye(3) - np.outer(at, at))
    six = [float(second[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    return [mass, *first.tolist(), *six], tuple(data.xpos[body].tolist())
