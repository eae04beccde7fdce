"""Inputs and outputs of a robot's controller: readings scaled to [-1, 1] in, motor commands out."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.catalogue.part_lost import lost_masks
from estexp_jax.physics.model.actuators import unusual_actuator
from estexp_jax.physics.model.robot import Robot

_SWING = np.pi / 4
"""Reach of the paper's joints to either side, rad."""


@final
@dataclass(frozen=True, eq=False)
class Interface:
    """Addresses and scales of a robot's controller inputs and outputs; all arrays are constants of the robot.

    Readings are raw sensor values, touch as +1 (contact) or -1; inputs are readings about their centre over their
    scale, clipped to [-1, 1].

    Attributes:
        columns: (n_inputs,) addresses in `sensordata` of the readings that are inputs.
        is_touch: (n_inputs,) bool.
        qpos: (n_inputs,) address in qpos of the joint a position sensor reads, 0 for touch.
        centre, scale: (n_inputs,) of the readings.
        ctrl_centre, ctrl_scale, ctrl_low, ctrl_high: (nu,) of the commands.
        rest: (n_inputs,) what a reading shows when the sensor's part is lost: -1 for touch, the centre for an angle.
        lost: (n_parts, n_inputs) 1 where an input's sensor goes with a part.
    """

    columns: np.ndarray
    is_touch: np.ndarray
    qpos: np.ndarray
    centre: np.ndarray
    scale: np.ndarray
    ctrl_centre: np.ndarray
    ctrl_scale: np.ndarray
    ctrl_low: np.ndarray
    ctrl_high: np.ndarray
    rest: np.ndarray
    lost: np.ndarray
    names: tuple[str, ...]

    @property
    def n_inputs(self) -> int:
        """Number of readings the controller sees."""
        return len(self.columns)

    @property
    def n_outputs(self) -> int:
        """Number of motors it moves."""
        return len(self.ctrl_centre)

    def readings(self, qpos: jax.Array, sensordata: jax.Array) -> jax.Array:
        """Raw readings (n_inputs,): angles from the configuration (nq,), touch from the last step's `sensordata`.

        `sensordata` after a step belongs to the state before it, so angles are not taken from there.
        """
        touch = jnp.where(sensordata[self.columns] > 0.0, 1.0, -1.0)
        return jnp.where(self.is_touch, touch, qpos[self.qpos])

    def inputs(self, readings: jax.Array) -> jax.Array:
        """Controller inputs (..., n_inputs) of readings (..., n_inputs)."""
        return jnp.clip((readings - self.centre) / self.scale, -1.0, 1.0)

    def commands(self, outputs: jax.Array) -> jax.Array:
        """Commands (nu,) of network outputs (nu,) in [-1, 1]."""
        return jnp.clip(self.ctrl_centre + self.ctrl_scale * outputs, self.ctrl_low, self.ctrl_high)


def interface_of(robot: Robot) -> Interface:
    """The controller's view of a robot: its touch and joint-position sensors, and all its motors.

    Raises:
        InputError: there is no such sensor, or no actuator on a hinge or slide joint.
    """
    model = robot.model
    touch_type, angle_type = int(mujoco.mjtSensor.mjSENS_TOUCH), int(mujoco.mjtSensor.mjSENS_JOINTPOS)
    sensors = [i for i in range(model.nsensor) if int(model.sensor_type[i]) in (touch_type, angle_type)]
    if not sensors:
        right = robot.remedy or "add some to <sensor>"
        raise InputError("the robot has no touch and no jointpos sensor", where=robot.source, right=right)
    if not model.nactuator:
        raise InputError("the robot has no actuator", where=robot.source, right=robot.remedy)
    if (odd := unusual_actuator(model)) is not None:
        where = f"{robot.source}, actuator '{robot.names('actuator')[odd[0]]}'"
        raise InputError(f"the actuator has {odd[1]}", where=where, right="recover moves actuators with one input each")
    for a in range(model.nactuator):
        if robot.joint_of_actuator(a) not in robot.scalar_joints:
            where = f"{robot.source}, actuator '{robot.names('actuator')[a]}'"
            raise InputError("recover moves only actuators on hinge and slide joints", where=where)
    columns = model.sensor_adr[sensors]
    touch = model.sensor_type[sensors] == touch_type
    joints = np.where(touch, robot.scalar_joints[0], model.sensor_objid[sensors])
    home = robot.home()
    centre = np.where(touch, 0.0, home[model.jnt_qposadr[joints]])
    scale = np.where(touch, 1.0, [_reach(model, int(j)) for j in joints])
    return Interface(
        columns=columns,
        is_touch=touch,
        qpos=np.where(touch, 0, model.jnt_qposadr[joints]),
        centre=centre,
        scale=scale,
        rest=np.where(touch, -1.0, centre),
        lost=lost_masks(robot)["sensor"][:, columns],
        names=tuple(robot.names("sensor")[i] for i in sensors),
        **_commands(robot, home),
    )


def _reach(model: mujoco.MjModel, joint: int) -> float:
    """Half of a slide's range (0.1 m if it has none), or the paper's 45 degrees."""
    if int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_SLIDE):
        return float(np.ptp(model.jnt_range[joint])) / 2 if model.jnt_limited[joint] else 0.1
    return _SWING


def _commands(robot: Robot, home: np.ndarray) -> dict[str, np.ndarray]:
    """Centre, scale and limits of each command: positions around home, forces about zero up to the force range."""
    model = robot.model
    joints = model.actuator_trnid[:, 0]
    servo = (model.actuator_biastype != int(mujoco.mjtBias.mjBIAS_NONE)) & (model.actuator_biasprm[:, 1] != 0.0)
    gain = np.where(model.actuator_gainprm[:, 0] == 0.0, 1.0, model.actuator_gainprm[:, 0])
    force = np.where(model.actuator_forcelimited, np.abs(model.actuator_forcerange).max(axis=1) / np.abs(gain), np.inf)
    limit = np.where(model.actuator_ctrllimited, np.abs(model.actuator_ctrlrange).max(axis=1), np.inf)
    effort = np.minimum(force, limit)
    gear = model.actuator_gear[:, 0]
    limited = model.actuator_ctrllimited.astype(bool)
    centre = np.where(servo, home[model.jnt_qposadr[joints]] * gear, 0.0)
    reach = np.array([_reach(model, int(j)) for j in joints]) * gear
    scale = np.where(servo, reach, np.where(np.isfinite(effort), effort, 1.0))
    return {
        "ctrl_centre": centre,
        "ctrl_scale": scale,
        "ctrl_low": np.where(limited, model.actuator_ctrlrange[:, 0], centre - np.abs(scale)),
        "ctrl_high": np.where(limited, model.actuator_ctrlrange[:, 1], centre + np.abs(scale)),
    }
