"""Whether an open-loop engine simulates a user's robot as plain MuJoCo does, its readings included.

Each engine replays two physics steps from the states of `probes`. The referee is a loop over `mj_step` on the user's
model: for the C engine as it is; for the others, whose solver converges, with its solver run until it has converged.
"""

from __future__ import annotations

import copy
from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from estexp_jax.physics.command_schedule import CommandHistory, physics_steps
from estexp_jax.physics.effects.changes import encode, stack
from estexp_jax.physics.engines.closed_loop_agreement import HIGH, MEDIAN, Agreement
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.engines.probes import Probes, probes_of
from estexp_jax.physics.model.actuators import inputs_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.validation import BLOWN_UP, mujoco_warnings_suppressed
from estexp_jax.physics.window import InitialState, Window

_STEPS = 2
"""Physics steps from each state: with one, what an engine keeps from step to step would not show."""
_SLOW, _FAINT = 0.1, 1e-3
"""Speeds (rad/s, m/s) and readings (in the sensor's unit) below which errors are not relative."""
_OF_FORCES = 0.1
"""Weight of errors of forces and accelerations, which in single precision are less exact than the motion."""


class _Expected(NamedTuple):
    """Speeds (states, rows, nv) and readings (states, rows, nsensordata)."""

    qvel: np.ndarray
    sensors: np.ndarray


def open_loop_agreement(
    simulator: OpenLoopSimulator, robot: Robot, windows: Sequence[Window] = (), *, converged: bool = True
) -> Agreement:
    """Distance of an open-loop simulator from plain MuJoCo, with each of its executables.

    Errors are the largest of speeds, relative to the largest of their state, and of readings, relative to the sensor's
    largest in all states. All kinds of states have to agree, each by its median.

    Args:
        simulator: the engine.
        robot: as it was in the first of the simulator's recordings.
        windows: of recordings, from whose states it is tried as well.
        converged: whether the referee's solver is run until it has converged.
    """
    with mujoco_warnings_suppressed():
        probes = probes_of(robot, windows)
        expected = _referee(robot, probes, converged)
    errors, names = _errors(robot, _replayed(simulator, robot, probes), expected)
    return _judged(probes, errors, names)


def _replayed(simulator: OpenLoopSimulator, robot: Robot, probes: Probes) -> _Expected:
    step, n, first = float(robot.model.opt.timestep), len(probes.kind), probes.before.shape[1]
    time = step * np.arange(-first, _STEPS + 1)
    steps, on = physics_steps(time[first:], step), np.ones((len(time), robot.model.nactuator))
    windows = [
        Window(0, first, first + _STEPS, steps, CommandHistory(time, commands), on, InitialState(qpos, qvel))
        for commands, qpos, qvel in zip(_commands(probes), probes.qpos, probes.qvel, strict=True)
    ]
    values = stack([encode(simulator.robot, simulator.catalogue, ())] * n)
    found = simulator.replay(values, windows, np.arange(n))
    return _Expected(found.qvel, found.sensors)


def _commands(probes: Probes) -> np.ndarray:
    """Commands (states, rows, nu): those before each state, and from then on."""
    return np.concatenate([probes.before, np.repeat(probes.ctrl[:, None], _STEPS + 1, axis=1)], axis=1)


def _referee(robot: Robot, probes: Probes, converged: bool) -> _Expected:
    model = copy.copy(robot.model)
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_AUTORESET)
    if converged:
        model.opt.iterations, model.opt.ls_iterations, model.opt.tolerance = 100, 50, 1e-12
    data, shape = mujoco.MjData(model), (len(probes.kind), _STEPS + 1)
    found = _Expected(np.empty((*shape, model.nv)), np.empty((*shape, model.nsensordata)))
    for i, (qpos, qvel, ctrl, before) in enumerate(zip(*probes[1:], strict=True)):
        mujoco.mj_resetData(model, data)
        data.qpos[:], data.qvel[:], data.ctrl[:] = qpos, qvel, before[-1]
        _command_before(model, data, before)
        for row in range(_STEPS + 1):
            if row:
                data.ctrl[:] = ctrl
                mujoco.mj_step(model, data)
            warmstart, found.qvel[i, row] = data.qacc_warmstart.copy(), data.qvel
            mujoco.mj_forward(model, data)
            found.sensors[i, row], data.qacc_warmstart[:] = data.sensordata, warmstart
        if any(data.warning[kind].number for kind in BLOWN_UP):
            found.qvel[i] = np.nan
    return found


def _command_before(model: mujoco.MjModel, data: mujoco.MjData, before: np.ndarray) -> None:
    """Let delayed actuators have been commanded `before` (steps, nu) in the steps until now."""
    for a in np.flatnonzero(model.actuator_history[:, 0] > 0).tolist():
        n = int(model.actuator_history[a, 0])
        values = before[-n:, inputs_of(model, a)]
        mujoco.mj_initCtrlHistory(model, data, a, float(model.opt.timestep) * np.arange(-n, 0), values)


def _errors(robot: Robot, found: _Expected, expected: _Expected) -> tuple[np.ndarray, tuple[str, ...]]:
    """Errors (states, degrees of freedom and sensor values), and the names of these."""
    model, joints = robot.model, robot.names("joint")
    lost = ~(np.isfinite(expected.qvel).all(axis=(1, 2)) & np.isfinite(expected.sensors).all(axis=(1, 2)))
    speed = np.maximum(_SLOW, np.abs(expected.qvel).max(axis=(1, 2), initial=0.0))
    moving = np.abs(found.qvel - expected.qvel).max(axis=1) / speed[:, None]
    owner = np.repeat(np.arange(model.nsensor), model.sensor_dim)
    largest = np.zeros(model.nsensor)
    np.maximum.at(largest, owner, np.abs(expected.sensors[~lost]).max(axis=(0, 1), initial=0.0))
    reading = np.abs(found.sensors - expected.sensors).max(axis=1) / np.maximum(_FAINT, largest)[owner]
    forces = model.sensor_needstage == int(mujoco.mjtStage.mjSTAGE_ACC)
    reading *= np.where(forces, _OF_FORCES, 1.0)[owner]
    names = (
        *(f"the motion of joint '{joints[j]}'" for j in model.dof_jntid),
        *(f"sensor '{robot.names('sensor')[s]}'" for s in owner),
    )
    errors = np.concatenate([moving, reading], axis=1)
    errors[~np.isfinite(errors)] = np.inf
    errors[lost] = 0.0  # where MuJoCo itself diverges, nothing is to be compared
    return errors, names


def _judged(probes: Probes, errors: np.ndarray, names: tuple[str, ...]) -> Agreement:
    worst, kinds = errors.max(axis=1, initial=0.0), np.array(probes.kind)
    median, high = (_quantile(worst, share) for share in (0.5, 0.95))
    medians = {kind: _quantile(worst[kinds == kind], 0.5) for kind in dict.fromkeys(probes.kind)}
    wrong = max(medians, key=lambda kind: medians[kind])
    differing = ""
    if max(medians.values()) > MEDIAN or high > HIGH:
        of_each = np.array([_quantile(column[kinds == wrong], 0.5) for column in errors.T])
        at = int(np.argmax(of_each)) if medians[wrong] > MEDIAN else int(np.argmax(errors[np.argmax(worst)]))
        differing = f"{names[at]}, {wrong if medians[wrong] > MEDIAN else kinds[np.argmax(worst)]}"
    return Agreement(len(errors), _STEPS, median, high, float(worst.max()), differing)


def _quantile(errors: np.ndarray, share: float) -> float:
    return float(np.sort(errors)[int(share * (len(errors) - 1) + 0.5)])
