"""The generalised force that each joint would need on top of a model to move as it was recorded.

Between two rows the smoothed path gives the mean acceleration, and inverse dynamics the force that it takes:

    tau_missing = M(q) a + c(q, w) - tau_passive - tau_constraint - tau_motor,

all in the middle between the rows, under the command that is in force there. It is averaged over some rows: the noise
of accelerations all but cancels in their sum.

Source: MuJoCo documentation, "Inverse dynamics".
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, final

import mujoco
import numpy as np
from scipy.ndimage import uniform_filter1d

from estexp_jax.discovery.c_replay import switched
from estexp_jax.discovery.problem import Problem
from estexp_jax.physics.engines.motors import asked_torques, limited_commands
from estexp_jax.physics.model.actuators import affine_actuators, first_input
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import StateEstimate

_MEAN = 0.03
"""Length of time over which forces are averaged, s."""
_SCALAR = (int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE))


@final
@dataclass(frozen=True, eq=False)
class ForceResidual:
    """What one recording's joints lack, between its rows; n degrees of freedom as the model has them.

    Attributes:
        time: (intervals,) their middles, s.
        qpos, qvel: (intervals, nq), (intervals, nv).
        ctrl: (intervals, nu).
        motor: (intervals, nv) torque of the motors, N m or N.
        force: (intervals, nv) what is missing, N m or N.
        told: (intervals, nv) torque that the motors' commands ask for in all, without limits, N m or N.
        asked: (intervals, nv) the same beyond rest: of a position servo, of the way left to go.
        on: (intervals, nv) 1 where a motor of the joint is on, else 0.
    """

    time: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray
    ctrl: np.ndarray
    motor: np.ndarray
    force: np.ndarray
    told: np.ndarray
    asked: np.ndarray
    on: np.ndarray


def force_residual(model: mujoco.MjModel, recording: Recording, path: StateEstimate) -> ForceResidual:
    """What a model's joints lack to move along a path.

    Args:
        model: the robot that the recording is compared with.
        recording: commands and switches.
        path: where the robot was at each row.
    """
    span = np.diff(path.time)
    qvel = 0.5 * (path.qvel[1:] + path.qvel[:-1])
    qacc = np.diff(path.qvel, axis=0) / span[:, None]
    qpos = path.qpos[:-1].copy()
    for q, v, dt in zip(qpos, qvel, span, strict=True):
        mujoco.mj_integratePos(model, q, v, 0.5 * dt)
    motor, force = np.zeros_like(qvel), np.zeros_like(qvel)
    models = switched(model, recording.enable[:-1], {})
    data = mujoco.MjData(model)
    for k, there in enumerate(models):
        data.qpos[:], data.qvel[:], data.ctrl[:] = qpos[k], qvel[k], recording.ctrl[k]
        mujoco.mj_forward(there, data)
        motor[k] = data.qfrc_actuator
        data.qacc[:] = qacc[k]
        mujoco.mj_inverse(there, data)
        force[k] = data.qfrc_inverse - motor[k]
    rows = max(1, round(_MEAN / float(np.median(span))))
    steady = uniform_filter1d(force, rows, axis=0, mode="nearest")
    time, ctrl = path.time[:-1] + 0.5 * span, recording.ctrl[:-1]
    return ForceResidual(time, qpos, qvel, ctrl, motor, steady, *_asked(model, recording, qpos, qvel))


def _asked(model: mujoco.MjModel, recording: Recording, qpos: np.ndarray, qvel: np.ndarray) -> tuple[np.ndarray, ...]:
    """What commands ask of motors of hinges and slides, in all and beyond rest, and if one is on, (intervals, nv)."""
    on_joint = np.flatnonzero(affine_actuators(model) & (model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)))
    a = np.array([i for i in on_joint if int(model.jnt_type[model.actuator_trnid[i, 0]]) in _SCALAR], int)
    joint = model.actuator_trnid[a, 0]
    dof, limited = model.jnt_dofadr[joint], np.asarray(limited_commands(model, recording.ctrl[:-1]))
    command = limited[:, first_input(model)[a]]
    each = asked_torques(
        _by_actuator(model, a), np.arange(len(a)), qpos[:, model.jnt_qposadr[joint]], qvel[:, dof], command
    )
    told, asked, on = (np.zeros_like(qvel) for _ in range(3))
    enable = recording.enable[:-1, a]
    for total, torques in zip((told, asked), each, strict=True):
        for d, torque in zip(dof, (enable * np.asarray(torques)).T, strict=True):
            total[:, d] += torque
    for d, switch in zip(dof, enable.T, strict=True):
        on[:, d] = np.maximum(on[:, d], switch)
    return told, asked, on


class _Motors(NamedTuple):
    """Numbers of some motors, a row each, as of MuJoCo's model."""

    actuator_gear: np.ndarray
    actuator_gainprm: np.ndarray
    actuator_biasprm: np.ndarray
    actuator_biastype: np.ndarray


def _by_actuator(model: mujoco.MjModel, a: np.ndarray) -> _Motors:
    gear = model.actuator_gear[model.actuator_outadr[a]]
    return _Motors(gear, model.actuator_gainprm[a], model.actuator_biasprm[a], model.actuator_biastype[a])


def force_residuals(problem: Problem, models: Sequence[mujoco.MjModel], which: Sequence[int]) -> list[ForceResidual]:
    """`force_residual` of some recordings, whose models are given for all."""
    paths = {s.recording: s.path for s in problem.segments if s.path is not None}
    return [force_residual(models[i], problem.recordings[i], paths[i]) for i in which]


def driven(model: mujoco.MjModel, residuals: Sequence[ForceResidual]) -> np.ndarray:
    """Degrees of freedom of hinge and slide joints that a motor drives and that were seen to move."""
    on_joint = model.actuator_trntype == int(mujoco.mjtTrn.mjTRN_JOINT)
    joints = [int(j) for j in np.unique(model.actuator_trnid[on_joint, 0]) if int(model.jnt_type[j]) in _SCALAR]
    dofs = model.jnt_dofadr[joints] if joints else np.zeros(0, int)
    moved = np.any([r.qvel[:, dofs].any(axis=0) for r in residuals], axis=0)
    return dofs[moved]
