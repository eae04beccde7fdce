"""The torque a motor puts on its joint, from command, position and speed: before the step that it acts in.

force = clip((g0 + g1 l + g2 v) u + b0 + b1 l + b2 v, forcerange) with l = gear q, v = gear w; torque = gear force,
their sum at a joint clipped to its actuatorfrcrange. Fixed and affine actuators on hinges and slides count; those with
dynamics of their own do so with their command, not their activation.

Source: MuJoCo documentation, "Force generation".
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.sites import actuator_dofs, driven_actuators
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_AFFINE_GAIN, _AFFINE_BIAS = int(mujoco.mjtGain.mjGAIN_AFFINE), int(mujoco.mjtBias.mjBIAS_AFFINE)


def motor_torques(robot: Robot, model: mjx.Model, qpos: jax.Array, qvel: jax.Array, ctrl: jax.Array) -> jax.Array:
    """Motor torque at each degree of freedom, (nv,), N m or N."""
    driven, dofs = np.array(driven_actuators(robot), dtype=int), actuator_dofs(robot)
    if not driven.size:
        return jnp.zeros(robot.model.nv, qvel.dtype)
    position = qpos[robot.model.jnt_qposadr[robot.model.dof_jntid[dofs]]]
    each = motor_torque(model, driven, position, qvel[dofs], limited_commands(model, ctrl)[driven])
    torque = jnp.zeros(robot.model.nv, qvel.dtype).at[dofs].add(each)
    joint = robot.model.dof_jntid
    return _limited(robot.model.jnt_actfrclimited[joint], model.jnt_actfrcrange[joint], torque)


def motor_load(robot: Robot, model: mjx.Model, qpos: jax.Array, qvel: jax.Array, ctrl: jax.Array) -> jax.Array:
    """Sum of |torque| of all motors that drive a joint, each taken alone, N m or N; commands within their ranges."""
    driven, dofs = np.array(driven_actuators(robot), dtype=int), actuator_dofs(robot)
    position = qpos[robot.model.jnt_qposadr[robot.model.dof_jntid[dofs]]]
    return jnp.abs(motor_torque(model, driven, position, qvel[dofs], ctrl[driven])).sum()


def motor_torque(model: mjx.Model, a: np.ndarray, q: jax.Array, w: jax.Array, command: jax.Array) -> jax.Array:
    """Torque of motors `a`, each at its own joint's position and speed, under its own command; arrays of any one shape.

    Joints' common limits are left out.
    """
    gear = model.actuator_gear[a, 0]
    length, speed = gear * q, gear * w
    affine = (model.actuator_gaintype[a] == _AFFINE_GAIN).astype(np.float32)
    biased = (model.actuator_biastype[a] == _AFFINE_BIAS).astype(np.float32)
    g, b = model.actuator_gainprm[a], model.actuator_biasprm[a]
    force = (g[..., 0] + affine * (g[..., 1] * length + g[..., 2] * speed)) * command
    force = force + biased * (b[..., 0] + b[..., 1] * length + b[..., 2] * speed)
    return gear * _limited(model.actuator_forcelimited[a], model.actuator_forcerange[a], force)


def limited_commands(model: Any, ctrl: Any) -> jax.Array:
    """Commands (nu,) within their ranges."""
    return _limited(model.actuator_ctrllimited, model.actuator_ctrlrange, ctrl)


def idle_commands(model: Any, a: np.ndarray, q: Any, w: Any) -> jax.Array:
    """Commands (n,) at which motors `a` give no torque; damping that a position servo has on top does not count."""
    gear, g, b = model.actuator_gear[a, 0], model.actuator_gainprm[a, 0], model.actuator_biasprm[a]
    biased = model.actuator_biastype[a] == _AFFINE_BIAS
    bias = jnp.where(b[..., 1] != 0.0, b[..., 0] + b[..., 1] * gear * q, b[..., 0] + b[..., 2] * gear * w)
    found: Any = jnp.where(biased & (g != 0.0), -bias / jnp.where(g == 0.0, 1.0, g), 0.0)
    return found


def asked_torques(model: Any, a: np.ndarray, q: Any, w: Any, command: Any) -> tuple[jax.Array, jax.Array]:
    """Torque that commands of motors `a` ask for, in all and beyond that of `idle_commands`; without limits."""
    strength = model.actuator_gear[a, 0] * model.actuator_gainprm[a, 0]
    return strength * command, strength * (command - idle_commands(model, a, q, w))


@final
@dataclass(frozen=True, eq=False)
class Drives:
    """Which motors count at some sites: at an actuator it alone, at a joint all that drive it.

    Attributes:
        robot: the nominal robot.
        motors: (n_sites, most motors at a site) indices of actuators, filled up with any.
        there: likewise, 1.0 where there is such a motor, else 0.0.
        joint: (n_sites,) index of each site's joint.
        whole: whether all motors of a joint are meant, so that the joint's common limit counts.
    """

    robot: Robot
    motors: np.ndarray
    there: np.ndarray
    joint: np.ndarray
    whole: bool

    def torque(self, model: mjx.Model, q: jax.Array, w: jax.Array, command: jax.Array) -> jax.Array:
        """Motor torque (n_sites,) if the joints were at these positions and speeds (n_sites,).

        Args:
            model: one robot's.
            q: rad or m.
            w: speeds.
            command: (nu,) within the commands' ranges.
        """
        if not self.motors.size:
            return jnp.zeros_like(q)
        each = motor_torque(model, self.motors, q[:, None], w[:, None], command[self.motors])
        total = jnp.sum(each * self.there, axis=1)
        if not self.whole:
            return total
        limits = self.robot.model.jnt_actfrclimited[self.joint]
        return _limited(limits, model.jnt_actfrcrange[self.joint], total)

    def asked(self, model: mjx.Model, q: jax.Array, w: jax.Array, command: jax.Array) -> tuple[jax.Array, jax.Array]:
        """`asked_torques` (n_sites,) of each site's motors together; arguments as of `torque`."""
        if not self.motors.size:
            return jnp.zeros_like(q), jnp.zeros_like(q)
        each = asked_torques(model, self.motors, q[:, None], w[:, None], command[self.motors])
        command, beyond = (jnp.sum(x * self.there, axis=1) for x in each)
        return command, beyond

    def further(self, model: mjx.Model, command: jax.Array, more: jax.Array) -> jax.Array:
        """Commands (nu,) that ask for so much more torque (n_sites,) at each site, its motors for equal parts."""
        strength = model.actuator_gear[self.motors, 0] * model.actuator_gainprm[self.motors, 0]
        part = more[:, None] / np.maximum(self.there.sum(axis=1, keepdims=True), 1.0)
        further: Any = jnp.where(strength == 0.0, 0.0, part / jnp.where(strength == 0.0, 1.0, strength))
        return command.at[self.motors].add(further * self.there)

    def on(self, enable: jax.Array) -> jax.Array:
        """1.0 where a site's motor is on, (n_sites,), of switches (nu,)."""
        if not self.motors.size:
            return jnp.zeros(len(self.joint))
        return jnp.max(enable[self.motors] * self.there, axis=1)

    def limit(self) -> np.ndarray:
        """Largest torque of the motors at each site, (n_sites,), on the nominal robot."""
        each = [[scales.motor_limit(self.robot, int(a)) for a in row] for row in self.motors]
        return np.sum(np.reshape(each, self.motors.shape) * self.there, axis=1)

    def scaled(self, share: jax.Array, factor: Any) -> jax.Array:
        """Shares of motors (nu,) after the sites' motors are scaled by factors (n_sites,) or one for all."""
        scale = jnp.where(self.there > 0.0, jnp.broadcast_to(factor, self.joint.shape)[:, None], 1.0)
        return share.at[self.motors].multiply(scale)


def drives(robot: Robot, dofs: np.ndarray, motors: np.ndarray | None) -> Drives:
    """The motors at sites.

    Args:
        robot: the nominal robot.
        dofs: (n_sites,) velocity address of each site's joint.
        motors: (n_sites,) the actuator that is the site; None where sites are joints.
    """
    joint = robot.model.dof_jntid[dofs] if len(dofs) else np.zeros(0, int)
    if motors is not None:
        return Drives(robot, motors[:, None], np.ones((len(dofs), 1), np.float32), joint, whole=False)
    driven = driven_actuators(robot)
    found = [[a for a in driven if robot.joint_of_actuator(a) == j] for j in joint]
    most = max(map(len, found), default=0)
    filled = np.array([f + [0] * (most - len(f)) for f in found], dtype=int).reshape(len(dofs), most)
    there = np.array([[1.0] * len(f) + [0.0] * (most - len(f)) for f in found], np.float32).reshape(len(dofs), most)
    return Drives(robot, filled, there, joint, whole=True)


def _limited(limited: np.ndarray, limits: Any, value: Any) -> Any:
    return jnp.where(limited, jnp.clip(value, limits[..., 0], limits[..., 1]), value)
