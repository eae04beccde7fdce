"""Typical sizes of torque, inertia and speed on a robot, from its nominal model alone: where searches begin and end."""

from __future__ import annotations

import mujoco
import numpy as np

from estexp_jax.physics.model.actuators import gear_of, inputs_of
from estexp_jax.physics.model.robot import Robot


def motor_limit(robot: Robot, actuator: int) -> float:
    """Largest torque a motor can put on its joint, N m (or N): its force range, else what its command range gives.

    A position servo without either is taken to reach the gain times a quarter turn (or 0.1 m).
    """
    model = robot.model
    gear = abs(gear_of(model, actuator))
    if model.actuator_forcelimited[actuator]:
        return gear * float(np.max(np.abs(model.actuator_forcerange[actuator])))
    gain = float(np.abs(model.actuator_gainprm[actuator, 0]))
    if (limits := _first_range(model, actuator)) is not None:
        return gear * gain * float(np.max(np.abs(limits)))
    is_servo = model.actuator_biastype[actuator] != mujoco.mjtBias.mjBIAS_NONE
    joint = robot.joint_of_actuator(actuator)
    slide = joint is not None and int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_SLIDE)
    return gear * gain * ((0.1 if slide else np.pi / 2) if is_servo else 1.0)


def _first_range(model: mujoco.MjModel, actuator: int) -> np.ndarray | None:
    """Range (2,) of an actuator's first input; None where it has none."""
    inputs = inputs_of(model, actuator)
    return model.actuator_ctrlrange[inputs[0]] if inputs and model.actuator_ctrllimited[inputs[0]] else None


def joint_span(robot: Robot, joint: int) -> tuple[float, float]:
    """Range of a one-coordinate joint: its own, else half a turn (or 0.5 m) to either side of home."""
    model = robot.model
    if model.jnt_limited[joint]:
        return float(model.jnt_range[joint, 0]), float(model.jnt_range[joint, 1])
    home = float(robot.home()[model.jnt_qposadr[joint]])
    reach = 0.5 if int(model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_SLIDE) else float(np.pi)
    return home - reach, home + reach


def joint_speed(robot: Robot, joint: int) -> float:
    """A moderate speed of a one-coordinate joint: 1 rad/s, or 0.2 m/s of a slide."""
    return 0.2 if int(robot.model.jnt_type[joint]) == int(mujoco.mjtJoint.mjJNT_SLIDE) else 1.0


def command_reach(robot: Robot, actuator: int) -> float:
    """Size of a motor's commands: half its control range, else what gives it its largest torque."""
    model = robot.model
    if (limits := _first_range(model, actuator)) is not None:
        return 0.5 * float(np.ptp(limits))
    gain = abs(gear_of(model, actuator) * float(model.actuator_gainprm[actuator, 0]))
    return motor_limit(robot, actuator) / gain if gain > 0.0 else 1.0


def sensor_span(robot: Robot, sensor: int) -> tuple[float, float]:
    """Range of a sensor with one value."""
    model = robot.model
    joint = int(model.sensor_objid[sensor])
    if model.sensor_type[sensor] == mujoco.mjtSensor.mjSENS_JOINTPOS and joint in robot.scalar_joints:
        return joint_span(robot, joint)
    return -100.0, 100.0


def joint_inertia(robot: Robot, joint: int) -> float:
    """Inertia a one-coordinate joint feels in the home configuration, the others held still, kg m2 (or kg)."""
    model, data = robot.model, mujoco.MjData(robot.model)
    data.qpos[:] = robot.home()
    mujoco.mj_forward(model, data)
    full = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, full)
    dof = int(model.jnt_dofadr[joint])
    return float(full[dof, dof])


def carried_inertia(robot: Robot, body: int) -> float:
    """Largest inertia of a body and all that hangs from it about the origin of its frame, at home, kg m2."""
    model, data = robot.model, mujoco.MjData(robot.model)
    data.qpos[:] = robot.home()
    mujoco.mj_kinematics(model, data)
    total = np.zeros((3, 3))
    for b in robot.subtree(body):
        axes, arm = data.ximat[b].reshape(3, 3), data.xipos[b] - data.xpos[body]
        total += axes @ np.diag(model.body_inertia[b]) @ axes.T
        total += model.body_mass[b] * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return float(np.linalg.eigvalsh(total)[-1])


def gravity_torque(robot: Robot, joint: int) -> float:
    """Largest torque gravity puts on a joint over a turn of it (or on a slide along gravity), N m (or N)."""
    model, data = robot.model, mujoco.MjData(robot.model)
    address, dof = int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])
    peak = 0.0
    for angle in np.linspace(0.0, 2.0 * np.pi, 16, endpoint=False):
        data.qpos[:] = robot.home()
        data.qpos[address] += angle
        mujoco.mj_forward(model, data)
        peak = max(peak, abs(float(data.qfrc_bias[dof])))
    return peak


def joint_torque(robot: Robot, joint: int) -> float:
    """Torque that matters at a joint, N m (or N): its motors' limit or gravity's, else a share of its inertia."""
    limits = [motor_limit(robot, a) for a in range(robot.model.nactuator) if robot.joint_of_actuator(a) == joint]
    torque = max([*limits, gravity_torque(robot, joint)])
    return torque if torque > 0.0 else 10.0 * joint_inertia(robot, joint)


def rotor_inertia(robot: Robot, joint: int) -> float:
    """Largest plausible inertia of a motor's rotor at its joint, kg m2 (or kg): a geared servo's outweighs a link."""
    return max(5.0 * joint_inertia(robot, joint), 0.02 * joint_torque(robot, joint))
