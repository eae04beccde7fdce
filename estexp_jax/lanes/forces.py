"""Forces at the joints that are no constraint: motors, springs, dampers.

Source: MuJoCo documentation, "Force generation" and "Passive forces".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import final

import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.lanes.algebra import Scalar, add, clip, is_number, mul, sub
from estexp_jax.lanes.layout import Joint, Layout, Motor
from estexp_jax.lanes.model_parameters import ModelParameters
from estexp_jax.lanes.polynomials import damper, spring

_AFFINE_GAIN, _AFFINE_BIAS = int(mujoco.mjtGain.mjGAIN_AFFINE), int(mujoco.mjtBias.mjBIAS_AFFINE)
_OFF = mujoco.mjtDisableBit


@final
@dataclass
class JointForces:
    """Forces at each degree of freedom.

    Attributes:
        force: N m or N.
        damping: minus their derivative by the speed; what an implicit step treats implicitly.
        braking: the part of `damping` that is the joints' own dampers.
        motor: the motors' share of `force`.
        actuator: force of each actuator, by MuJoCo's index, as its sensors show it.
    """

    force: list[Scalar]
    damping: list[Scalar]
    braking: list[Scalar]
    motor: list[Scalar]
    actuator: dict[tuple[int, ...], Scalar] = field(default_factory=dict)


@final
@dataclass
class MotorCommands:
    """Commands of the motors, by the slots of `Motor`.

    Attributes:
        command: (k, N) for each slot.
        enable: (k, N), 1 where a motor is on; None where all are.
        share: (k, N) factors on their forces, limits included; None for none.
    """

    command: dict[tuple[int, ...], Scalar]
    enable: dict[tuple[int, ...], Scalar] | None = None
    share: dict[tuple[int, ...], Scalar] | None = None


def motor_commands(layout: Layout, ctrl: Sequence[Scalar]) -> MotorCommands:
    """Commands of all motors, all of them on, from one array (N,) for each of the model's `nu` actuators."""
    slots = [motor.ids for joint in layout.joints for motor in joint.motors]
    return MotorCommands({ids: ctrl[ids[0]] if len(ids) == 1 else jnp.stack([ctrl[i] for i in ids]) for ids in slots})


def joint_forces(
    layout: Layout,
    params: ModelParameters,
    positions: Sequence[Sequence[Scalar]],
    speed: Sequence[Scalar],
    commands: MotorCommands,
) -> JointForces:
    """Forces in a state.

    Args:
        layout: structure.
        params: of the robots.
        positions: per joint.
        speed: per degree of freedom.
        commands: of the motors.
    """
    n = len(layout.dofs)
    found = JointForces([0] * n, [0] * n, [0] * n, [0] * n)
    for joint, q in zip(layout.joints, positions, strict=True):
        for dof in joint.dofs:
            _brake(layout, params, found, dof, speed[dof])
        if not joint.free:
            _spring(layout, params, found, joint, q[0])
            _drive(layout, params, found, joint, q[0], speed[joint.dofs[0]], commands)
    return found


def _brake(layout: Layout, params: ModelParameters, found: JointForces, dof: int, speed: Scalar) -> None:
    if layout.model.opt.disableflags & _OFF.mjDSBL_DAMPER:
        return
    damping = params.get("dof_damping", layout.dofs[dof].addresses)
    found.force[dof] = sub(found.force[dof], mul(damping, speed))
    square, cube = (params.get("dof_dampingpoly", layout.dofs[dof].addresses, i) for i in range(2))
    if not (is_number(square, 0) and is_number(cube, 0)):
        more = damper(square, cube, speed)
        found.force[dof], damping = add(found.force[dof], more.force), add(damping, more.slope)
    found.damping[dof] = add(found.damping[dof], damping)
    found.braking[dof] = damping


def _spring(layout: Layout, params: ModelParameters, found: JointForces, joint: Joint, q: Scalar) -> None:
    stiffness = params.get("jnt_stiffness", joint.ids)
    square, cube = (params.get("jnt_stiffnesspoly", joint.ids, i) for i in range(2))
    absent = all(is_number(x, 0) for x in (stiffness, square, cube))
    if absent or layout.model.opt.disableflags & _OFF.mjDSBL_SPRING:
        return
    extension = sub(q, params.get("qpos_spring", joint.qpos))
    found.force[joint.dofs[0]] = sub(found.force[joint.dofs[0]], mul(stiffness, extension))
    if not (is_number(square, 0) and is_number(cube, 0)):
        own = params.known(layout.model.qpos_spring[np.asarray(joint.qpos)])  # what effects add rests where they say
        found.force[joint.dofs[0]] = add(found.force[joint.dofs[0]], spring(square, cube, sub(q, own)).force)


def _drive(
    layout: Layout,
    params: ModelParameters,
    found: JointForces,
    joint: Joint,
    q: Scalar,
    speed: Scalar,
    commands: MotorCommands,
) -> None:
    if not joint.motors or layout.model.opt.disableflags & _OFF.mjDSBL_ACTUATION:
        return
    torque: Scalar = 0
    slope: Scalar = 0
    for motor in joint.motors:
        gear = params.get("actuator_gear", motor.ids, 0)
        force, by_speed = motor_force(layout, params, motor, mul(gear, q), mul(gear, speed), commands)
        found.actuator[motor.ids] = force
        torque = add(torque, mul(gear, force))
        slope = add(slope, mul(mul(gear, gear), by_speed))
    if layout.model.jnt_actfrclimited[joint.ids[0]]:
        low, high = (params.get("jnt_actfrcrange", joint.ids, i) for i in range(2))
        torque = clip(torque, low, high)
    dof = joint.dofs[0]
    found.motor[dof] = torque
    found.force[dof] = add(found.force[dof], torque)
    found.damping[dof] = sub(found.damping[dof], slope)


def motor_force(
    layout: Layout, params: ModelParameters, motor: Motor, length: Scalar, rate: Scalar, commands: MotorCommands
) -> tuple[Scalar, Scalar]:
    """An actuator's force, and its derivative by its own rate: zero where the force range clips it."""
    model, ids = layout.model, motor.ids
    command = commands.command[ids]
    if model.actuator_ctrllimited[ids[0]] and not model.opt.disableflags & _OFF.mjDSBL_CLAMPCTRL:
        command = clip(command, *(params.get("actuator_ctrlrange", ids, i) for i in range(2)))
    gain = params.get("actuator_gainprm", ids, 0)
    slope: Scalar = 0
    if model.actuator_gaintype[ids[0]] == _AFFINE_GAIN:
        by_length, by_rate = (params.get("actuator_gainprm", ids, i) for i in (1, 2))
        gain = add(gain, add(mul(by_length, length), mul(by_rate, rate)))
        slope = mul(by_rate, command)
    force = mul(gain, command)
    if model.actuator_biastype[ids[0]] == _AFFINE_BIAS:
        constant, by_length, by_rate = (params.get("actuator_biasprm", ids, i) for i in range(3))
        force = add(force, add(constant, add(mul(by_length, length), mul(by_rate, rate))))
        slope = add(slope, by_rate)
    if commands.enable is not None:
        force, slope = mul(force, commands.enable[ids]), mul(slope, commands.enable[ids])
    if model.actuator_forcelimited[ids[0]]:
        low, high = (params.get("actuator_forcerange", ids, i) for i in range(2))
        if not is_number(slope, 0):
            slope = jnp.where((force <= low) | (force >= high), 0.0, slope)
        force = clip(force, low, high)
    if commands.share is not None:
        force, slope = mul(force, commands.share[ids]), mul(slope, commands.share[ids])
    return force, slope
