"""Constants that MuJoCo derives from a model when it compiles it, derived again after an edit of masses or inertias.

MuJoCo scales each constraint's softness by the inverse inertia it meets at qpos0 (`dof_invweight0`, `body_invweight0`),
and divides by `body_subtreemass`. MJX keeps what was compiled: a mass edit alone leaves contacts with wrong softness.

Source: MuJoCo `engine_setconst.c`, mj_setConst; checked against recompiled models in the tests.
"""

from __future__ import annotations

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.robot import Robot

_FREE, _BALL = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_BALL)


def refresh(robot: Robot, model: mjx.Model) -> mjx.Model:
    """The model with `body_subtreemass`, `dof_invweight0` and `body_invweight0` of its present masses and inertias.

    `actuator_acc0` and the tendons' constants are left alone: only muscles and tendon constraints read them.
    """
    data = mjx.make_data(robot.model).replace(qpos=model.qpos0)
    data = mjx.crb(model, mjx.com_pos(model, mjx.kinematics(model, data)))
    inverse = _inverse(mjx.full_m(model, data))
    return model.replace(
        body_subtreemass=_subtree_mass(robot.model, model.body_mass),
        dof_invweight0=_dofs(robot.model, model.body_mass, inverse),
        body_invweight0=_bodies(robot.model, model, data, inverse),
    )


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


def _bodies(nominal: mujoco.MjModel, model: mjx.Model, data: mjx.Data, inverse: jax.Array) -> jax.Array:
    """(nbody, 2): mean inverse inertia at each body's centre of mass, translational and rotational; 0 if fixed."""

    def one(point: jax.Array, body: jax.Array) -> jax.Array:
        translation, rotation = mjx.jac(model, data, point, body)
        means = [jnp.trace(j.T @ inverse @ j) / 3.0 for j in (translation, rotation)]
        return jnp.maximum(jnp.stack(means), mujoco.mjMINVAL)

    moving = jnp.asarray(nominal.body_weldid != 0)[:, None]
    general = jax.vmap(one)(data.xipos, jnp.arange(nominal.nbody))
    slider = jnp.stack([1.0 / model.body_mass, jnp.zeros(nominal.nbody, model.body_mass.dtype)], axis=1)
    general = jnp.where(_slider(nominal)[:, None], slider, general)
    return jnp.where(moving, general, 0.0)
