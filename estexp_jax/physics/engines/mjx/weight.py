"""Torques that gravity puts on hinges and slides, on MJX."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import mujoco
from mujoco import mjx

from estexp_jax.physics.model.robot import Robot


def torques_of_weight(robot: Robot, model: mjx.Model, qpos: jax.Array) -> jax.Array:
    """Torque of gravity (nv,) on each degree of freedom: its axis' part of the weight of all that its joint carries.

    Args:
        robot: the nominal robot.
        model: one robot's.
        qpos: (nq,).

    Returns:
        N m or N; nothing of ball and free joints.
    """
    at = mjx.com_pos(model, mjx.kinematics(model, mjx.make_data(robot.model).replace(qpos=qpos)))
    joints = robot.model.dof_jntid
    body = robot.model.jnt_bodyid[joints]
    weight = model.body_subtreemass[body, None] * model.opt.gravity
    moment = jnp.cross(at.subtree_com[body] - at.xanchor[joints], weight)
    slides = (robot.model.jnt_type[joints] == int(mujoco.mjtJoint.mjJNT_SLIDE))[:, None]
    return jnp.sum(at.xaxis[joints] * jnp.where(slides, weight, moment), axis=1)
