"""Computed-torque control of joints with torque motors: under open-loop torques an arm falls and shows little."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import mujoco
import numpy as np

from estexp_jax.experiment_design.excitation import excitation_range
from estexp_jax.physics.model.actuators import affine_actuators, first_input, gear_of, position_input
from estexp_jax.physics.model.robot import Robot

_REACH = {int(mujoco.mjtJoint.mjJNT_HINGE): 0.6, int(mujoco.mjtJoint.mjJNT_SLIDE): 0.2}
"""Amplitude of a joint about home where no range limits it: rad, m."""
_INSIDE = 0.9
"""Share of a joint's range that is used."""
_HERTZ, _PER_PERIOD = 3.0, 0.2
"""Closed-loop natural frequency, Hz; for low sampling rates at most so many radians a period."""
_EASE = 1.0
"""Duration of the transition from home to the planned motion, s."""


def torque_motors(robot: Robot) -> tuple[int, ...]:
    """Actuators that alone drive a hinge or slide, with a torque (or force) in proportion to the command.

    A robot with a floating base has none: its legs cannot hold it in place.
    """
    model = robot.model
    if any(int(kind) == int(mujoco.mjtJoint.mjJNT_FREE) for kind in model.jnt_type):
        return ()
    fixed, none = int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtBias.mjBIAS_NONE)
    plain = (model.actuator_gaintype == fixed) & (model.actuator_biastype == none)
    plain &= (model.actuator_dyntype == int(mujoco.mjtDyn.mjDYN_NONE)) & (model.actuator_gainprm[:, 0] != 0.0)
    plain &= affine_actuators(model) & (model.actuator_gear[model.actuator_outadr, 0] != 0.0)
    driven = [robot.joint_of_actuator(a) for a in range(model.nactuator)]
    alone = [a for a in np.flatnonzero(plain).tolist() if driven.count(driven[a]) == 1]
    return tuple(a for a in alone if driven[a] in robot.scalar_joints)


def controlled_commands(
    robot: Robot, motors: tuple[int, ...], commands: np.ndarray, period: float
) -> ComputedTorqueController:
    """A controller that moves the motors' joints over the same share of their ranges as commands have of the motors'.

    Args:
        robot: the nominal one.
        motors: `torque_motors`.
        commands: (rows, nu) of an excitation; those of other actuators are passed on unchanged.
        period: time between rows, s.
    """
    at, (centre, usual) = first_input(robot.model)[list(motors)], excitation_range(robot)
    middle, reach = _joint_reach(robot, motors)
    share = (commands[:, at] - centre[at]) / usual[at]
    return ComputedTorqueController(robot, commands, motors, middle + reach * share, period)


def planned_path(robot: Robot, motors: tuple[int, ...], commands: np.ndarray, period: float) -> np.ndarray:
    """Configurations (rows, nq) that commands ask for; joints without a servo or motor stay at home.

    The joints of motors move as of `controlled_commands`, those of servos as commanded. Arguments as there.
    """
    model, path = robot.model, np.tile(robot.home(), (len(commands), 1))
    for a in range(model.nactuator):
        joint, gear, target = robot.joint_of_actuator(a), gear_of(model, a), position_input(model, a)
        if joint in robot.scalar_joints and target is not None and gear != 0.0:
            path[:, model.jnt_qposadr[joint]] = commands[:, target] / gear
    if motors:
        path[:, model.jnt_qposadr[_joints(robot, motors)]] = controlled_commands(robot, motors, commands, period).path[
            0
        ]
    return path


def _joint_reach(robot: Robot, motors: Sequence[int]) -> tuple[np.ndarray, np.ndarray]:
    """Centre and amplitude (motors,) of the motions of motors' joints: about home, within their range, rad or m."""
    model, home = robot.model, robot.home()
    middle, reach = np.zeros(len(motors)), np.zeros(len(motors))
    for i, joint in enumerate(_joints(robot, motors)):
        middle[i], reach[i] = home[model.jnt_qposadr[joint]], _REACH[int(model.jnt_type[joint])]
        if model.jnt_limited[joint]:
            low, high = model.jnt_range[joint]
            reach[i] = min(reach[i], _INSIDE * (high - low) / 2.0)
            edge = reach[i] + (1.0 - _INSIDE) * (high - low) / 2.0
            middle[i] = np.clip(middle[i], low + edge, high - edge)
    return middle, reach


def _joints(robot: Robot, motors: Sequence[int]) -> list[int]:
    return [joint for a in motors if (joint := robot.joint_of_actuator(a)) is not None]


@final
@dataclass(frozen=True, eq=False)
class ComputedTorqueController:
    """Computed-torque controller from the nominal model, for joints with torque motors.

        torque = M(q) (a + w^2 (q_planned - q) + 2 w (v_planned - v)) + bias(q, v) - passive(q, v)

    Physics that the nominal model lacks, such as friction, shows as a tracking error.

    Source: Siciliano et al., Robotics: Modelling, Planning and Control (2009), section 8.5.2.

    Attributes:
        robot: the nominal one.
        commands: (rows, nu) of the other actuators.
        motors: `torque_motors`.
        planned: (rows, motors) positions of their joints, rad or m.
        period: time between rows, s.
    """

    robot: Robot
    commands: np.ndarray
    motors: tuple[int, ...]
    planned: np.ndarray
    period: float

    def __call__(self, time: float, qpos: np.ndarray, qvel: np.ndarray) -> np.ndarray:
        """Commands (nu,) at a time (s), for the state (nq,), (nv,) at that time."""
        model, data = self.robot.model, self._data
        row = min(round(time / self.period), len(self.commands) - 1)
        data.qpos[:], data.qvel[:] = qpos, qvel
        mujoco.mj_forward(model, data)
        inertia = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, inertia)
        fast = min(2.0 * np.pi * _HERTZ, _PER_PERIOD / self.period)
        joints = _joints(self.robot, self.motors)
        places, dofs, motors = model.jnt_qposadr[joints], model.jnt_dofadr[joints], list(self.motors)
        asked = np.zeros(model.nv)
        where, speed, pace = (table[row] for table in self.path)
        asked[dofs] = pace + fast**2 * (where - qpos[places]) + 2.0 * fast * (speed - qvel[dofs])
        torque = (inertia @ asked + data.qfrc_bias - data.qfrc_passive)[dofs]
        found = self.commands[row].copy()
        gear = model.actuator_gear[model.actuator_outadr[motors], 0]
        found[first_input(model)[motors]] = torque / (gear * model.actuator_gainprm[motors, 0])
        low, high = np.where(model.actuator_ctrllimited[:, None], model.actuator_ctrlrange, [-np.inf, np.inf]).T
        return np.clip(found, low, high)

    @cached_property
    def _data(self) -> mujoco.MjData:
        return mujoco.MjData(self.robot.model)

    @cached_property
    def path(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Positions, speeds and accelerations (rows, motors); they begin at home at rest."""
        home = self.robot.home()[self.robot.model.jnt_qposadr[_joints(self.robot, self.motors)]]
        share = np.clip(self.period * np.arange(len(self.planned)) / _EASE, 0.0, 1.0)
        eased = (share**3 * (10.0 - 15.0 * share + 6.0 * share**2))[:, None]
        where = home + eased * (self.planned - home)
        speed = np.gradient(where, self.period, axis=0)
        return where, speed, np.gradient(speed, self.period, axis=0)
