"""Sensors and units of the channels that figures and tables show."""

from __future__ import annotations

import mujoco
import numpy as np

from estexp_jax.physics.effects.units import unit_at
from estexp_jax.physics.model.robot import Robot

_UNITS = {
    mujoco.mjtSensor.mjSENS_JOINTVEL: "rad/s",
    mujoco.mjtSensor.mjSENS_ACTUATORVEL: "rad/s",
    mujoco.mjtSensor.mjSENS_GYRO: "rad/s",
    mujoco.mjtSensor.mjSENS_VELOCIMETER: "m/s",
    mujoco.mjtSensor.mjSENS_ACCELEROMETER: "m/s^2",
    mujoco.mjtSensor.mjSENS_FORCE: "N",
    mujoco.mjtSensor.mjSENS_TOUCH: "N",
    mujoco.mjtSensor.mjSENS_TORQUE: "N m",
    mujoco.mjtSensor.mjSENS_FRAMEPOS: "m",
    mujoco.mjtSensor.mjSENS_RANGEFINDER: "m",
}


def sensor_of(robot: Robot, channel: str) -> int:
    """Index of the sensor to which a channel belongs; the channel is one of `robot.sensor_columns()`."""
    column = robot.sensor_columns().index(channel)
    return int(np.searchsorted(robot.model.sensor_adr, column, side="right")) - 1


def unit_of(robot: Robot, channel: str) -> str:
    """Unit of a sensor's channel or of `qpos.<joint>`; empty if it has none, or none is known."""
    if channel not in robot.sensor_columns():
        return _unit_on_joint(robot, robot.index("joint", channel.removeprefix("qpos.")), "rad")
    model, sensor = robot.model, sensor_of(robot, channel)
    kind, target = mujoco.mjtSensor(int(model.sensor_type[sensor])), int(model.sensor_objid[sensor])
    match kind:
        case mujoco.mjtSensor.mjSENS_JOINTPOS | mujoco.mjtSensor.mjSENS_JOINTVEL:
            return _unit_on_joint(robot, target, _UNITS.get(kind, "rad"))
        case mujoco.mjtSensor.mjSENS_JOINTACTFRC:
            return _unit_on_joint(robot, target, "N m")
        case mujoco.mjtSensor.mjSENS_ACTUATORFRC:
            joint = robot.joint_of_actuator(target)
            return "" if joint is None else _unit_on_joint(robot, joint, "N m")
        case _:
            return _UNITS.get(kind, "")


def _unit_on_joint(robot: Robot, joint: int, unit: str) -> str:
    return unit_at(robot, "joint", robot.names("joint")[joint], unit)
