"""The torque a motor puts on its joint, from command, position and speed: before the step that it acts in."""

from __future__ import annotations

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.sites import actuator_dofs, driven_actuators
from estexp_jax.physics.robot import Robot

_AFFINE_GAIN, _AFFINE_BIAS = int(mujoco.mjtGain.mjGAIN_AFFINE), int(mujoco.mjtBias.mjBIAS_AFFINE)


def motor_torques(robot: Robot, model: mjx.Model, qpos: jax.Array, qvel: jax.Array, ctrl: jax.Array) -> jax.Array:
    """Motor torque at each degree of freedom, (nv,), N m or N, for fixed and affine actuators on hinges and slides.

    force = clip((g0 + g1 l + g2 v) u + b0 + b1 l + b2 v, forcerange) with l = gear q, v = gear w; torque = gear force,
    their sum at a joint clipped to its actuatorfrcrange.
    Actuators with dynamics of their own count with their command, not their activation.

    Source: MuJoCo documentation, "Force generation".
    """
    driven = np.array(driven_actuators(robot), dtype=int)
    if not driven.size:
        return jnp.zeros(robot.model.nv, qvel.dtype)
    joints = [robot.joint_of_actuator(int(a)) for a in driven]
    gear = model.actuator_gear[driven, 0]
    length = gear * qpos[robot.model.jnt_qposadr[joints]]
    speed = gear * qvel[robot.model.jnt_dofadr[joints]]
    command = _limited(robot.model.actuator_ctrllimited[driven], model.actuator_ctrlrange[driven], ctrl[driven])
    affine = (robot.model.actuator_gaintype[driven] == _AFFINE_GAIN).astype(np.float32)
    biased = (robot.model.actuator_biastype[driven] == _AFFINE_BIAS).astype(np.float32)
    g, b = model.actuator_gainprm[driven], model.actuator_biasprm[driven]
    force = (g[:, 0] + affine * (g[:, 1] * length + g[:, 2] * speed)) * command
    force = force + biased * (b[:, 0] + b[:, 1] * length + b[:, 2] * speed)
    force = _limited(robot.model.actuator_forcelimited[driven], model.actuator_forcerange[driven], force)
    torque = jnp.zeros(robot.model.nv, qvel.dtype).at[actuator_dofs(robot)].add(gear * force)
    joint = robot.model.dof_jntid
    return _limited(robot.model.jnt_actfrclimited[joint], model.jnt_actfrcrange[joint], torque)


def _limited(limited: np.ndarray, limits: jax.Array, value: jax.Array) -> jax.Array:
    return jnp.where(limited, jnp.clip(value, limits[:, 0], limits[:, 1]), value)
