"""Constants that MuJoCo derives from a model when it compiles it, derived again after an edit of masses or inertias.

MuJoCo scales each constraint's softness by the inverse inertia it meets at qpos0 (`dof_invweight0`, `body_invweight0`),
and divides by `body_subtreemass`. MJX keeps what was compiled: a mass edit alone leaves contacts with wrong softness.

Source: MuJoCo `engine_setconst.c`, mj_setConst; checked against recompiled models in the tests.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.physics.model.robot import Robot

if TYPE_CHECKING:
    from mujoco import mjx  # seconds that whoever only reads a model would wait

_JOINT = mujoco.mjtJoint
_FREE, _BALL = int(_JOINT.mjJNT_FREE), int(_JOINT.mjJNT_BALL)


def refresh(robot: Robot, model: mjx.Model) -> mjx.Model:
    """The model with `body_subtreemass`, `dof_invweight0` and `body_invweight0` of its present masses and inertias.

    With J_t and J_r the Jacobians of the bodies' centres of mass at qpos0, m their masses and I their inertias:

        M = sum over bodies of (J_t^T m J_t + J_r^T I J_r) + diag(armature)

    Written out here, since tracing and compiling MJX's own passes for it took longer than all else that an edit needs.
    `actuator_acc0` and the tendons' constants are left alone: only muscles and tendon constraints read them.
    """
    moves = _jacobians(robot.model, model)
    inverse = _inverse(_mass_matrix(model, moves))
    return model.replace(
        body_subtreemass=_subtree_mass(robot.model, model.body_mass),
        dof_invweight0=_dofs(robot.model, model.body_mass, inverse),
        body_invweight0=_bodies(robot.model, model.body_mass, moves, inverse),
    )


class _Jacobians(NamedTuple):
    """Velocity of each body's centre of mass in world axes, and spin in its principal axes, (nbody, 3, nv)."""

    translation: jax.Array
    rotation: jax.Array


def _jacobians(nominal: mujoco.MjModel, model: mjx.Model) -> _Jacobians:
    turn, place = _frames(nominal, model)
    kind = nominal.jnt_type[nominal.dof_jntid]
    coordinate = np.arange(nominal.nv) - nominal.jnt_dofadr[nominal.dof_jntid]
    unit = np.eye(3)[coordinate % 3]
    shifts = (kind == int(_JOINT.mjJNT_SLIDE)) | ((kind == _FREE) & (coordinate < 3))
    scalar = (kind != _FREE) & (kind != _BALL)
    local = jnp.where(scalar[:, None], model.jnt_axis[nominal.dof_jntid], unit)
    own = turn[nominal.dof_bodyid]
    axis = jnp.where(((kind == _FREE) & shifts)[:, None], unit, _applied(own, local))
    anchor = place[nominal.dof_bodyid] + _applied(own, model.jnt_pos[nominal.dof_jntid])
    centre = place + _applied(turn, model.body_ipos)
    swept = jnp.cross(axis, centre[:, None] - anchor)
    moved = _moved(nominal)[..., None]
    spin = jnp.where(moved & ~shifts[:, None], axis, 0.0)
    principal = turn @ _rotations(model.body_iquat)
    return _Jacobians(
        jnp.swapaxes(jnp.where(moved, jnp.where(shifts[:, None], axis, swept), 0.0), 1, 2),
        jnp.einsum("bxi,bdx->bid", principal, spin),
    )


def _frames(nominal: mujoco.MjModel, model: mjx.Model) -> tuple[jax.Array, jax.Array]:
    """Axes (nbody, 3, 3) and origins (nbody, 3) of the bodies at qpos0, where no joint has moved."""
    own = _rotations(model.body_quat)
    turn, place = [own[0]], [model.body_pos[0]]
    for body in range(1, nominal.nbody):
        above = int(nominal.body_parentid[body])
        place.append(place[above] + turn[above] @ model.body_pos[body])
        turn.append(turn[above] @ own[body])
    return jnp.stack(turn), jnp.stack(place)


def _moved(nominal: mujoco.MjModel) -> np.ndarray:
    """(nbody, nv) whether a degree of freedom moves a body."""
    moved = np.zeros((nominal.nbody, nominal.nv), bool)
    for body in range(1, nominal.nbody):
        first = nominal.body_dofadr[body]
        moved[body] = moved[nominal.body_parentid[body]]
        moved[body, first : first + nominal.body_dofnum[body]] = True
    return moved


def _rotations(quaternions: jax.Array) -> jax.Array:
    """Rotation matrices (n, 3, 3) of unit quaternions (n, 4): 2 (u u^T - |u|^2 1) + 2 w [u]x + 1."""
    w, u = quaternions[:, :1, None], quaternions[:, 1:]
    across = jnp.cross(u[:, None], -jnp.eye(3, dtype=u.dtype))
    square = u[:, :, None] * u[:, None] - jnp.sum(u * u, axis=1)[:, None, None] * jnp.eye(3, dtype=u.dtype)
    return jnp.eye(3, dtype=u.dtype) + 2.0 * (square + w * across)


def _applied(rotations: jax.Array, vectors: jax.Array) -> jax.Array:
    return jnp.einsum("nij,nj->ni", rotations, vectors)


def _mass_matrix(model: mjx.Model, moves: _Jacobians) -> jax.Array:
    weighed = model.body_mass[:, None, None] * moves.translation
    turned = model.body_inertia[:, :, None] * moves.rotation
    pairs = ((moves.translation, weighed), (moves.rotation, turned))
    return sum((jnp.einsum("bxi,bxj->ij", a, b) for a, b in pairs), jnp.diag(model.dof_armature))


def _inverse(matrix: jax.Array) -> jax.Array:
    factor = jax.scipy.linalg.cho_factor(matrix)
    return jax.scipy.linalg.cho_solve(factor, jnp.eye(matrix.shape[0], dtype=matrix.dtype))


def _subtree_mass(nominal: mujoco.MjModel, mass: jax.Array) -> jax.Array:
    inside = np.eye(nominal.nbody)
    for body in range(nominal.nbody - 1, 0, -1):
        inside[nominal.body_parentid[body]] += inside[body]
    return jnp.asarray(inside, mass.dtype) @ mass


def _slider(nominal: mujoco.MjModel) -> np.ndarray:
    """(nbody,) bodies on slides alone that carry nothing: MuJoCo takes their mass, without armature, for all."""
    return nominal.body_simple == 2


def _dofs(nominal: mujoco.MjModel, mass: jax.Array, inverse: jax.Array) -> jax.Array:
    """(nv,): the diagonal of the inverse inertia, alike for the coordinates of one joint."""
    general = _per_joint_mean(nominal, jnp.diagonal(inverse))
    return jnp.where(_slider(nominal)[nominal.dof_bodyid], 1.0 / mass[nominal.dof_bodyid], general)


def _per_joint_mean(nominal: mujoco.MjModel, diagonal: jax.Array) -> jax.Array:
    """Free joints get one value for their three translations and one for their rotations, ball joints one."""
    mean = np.eye(nominal.nv)
    for joint in range(nominal.njnt):
        dof, kind = int(nominal.jnt_dofadr[joint]), int(nominal.jnt_type[joint])
        for start in {_FREE: (dof, dof + 3), _BALL: (dof,)}.get(kind, ()):
            mean[start : start + 3, start : start + 3] = 1.0 / 3.0
    return jnp.asarray(mean, diagonal.dtype) @ diagonal


def _bodies(nominal: mujoco.MjModel, mass: jax.Array, moves: _Jacobians, inverse: jax.Array) -> jax.Array:
    """(nbody, 2): mean inverse inertia at each body's centre of mass, translational and rotational; 0 if fixed."""
    general = jnp.stack([jnp.einsum("bxi,ij,bxj->b", j, inverse, j) / 3.0 for j in moves], axis=1)
    general = jnp.maximum(general, mujoco.mjMINVAL)
    slider = jnp.stack([1.0 / mass, jnp.zeros_like(mass)], axis=1)
    general = jnp.where(_slider(nominal)[:, None], slider, general)
    return jnp.where((nominal.body_weldid != 0)[:, None], general, 0.0)
