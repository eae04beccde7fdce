"""Test a first mapping: does the nominal model predict the log far better with columns exchanged, or a sign turned?

Short pieces of the log are replayed in plain MuJoCo, each from the state that its readings show: as they are mapped,
and with each plausible other mapping. What physics is missing makes all of them worse alike.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from typing import final

import mujoco
import numpy as np

from estexp_jax.physics.model.actuators import actuator_of_input, position_input
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_PIECES, _PIECE_S, _SLOPE_S = 8, 0.3, 0.02
_FAR_BETTER, _NOT_EXACT = 0.5, 0.02
"""Another mapping must halve the error, and the error must be above this share of the joints' ranges."""
_MOST_JOINTS = 16
_DEGREE, _TURN = math.pi / 180.0, 2.0 * math.pi
"""What moves less than a turn is no angle in degrees: a smaller command would stand in for friction."""


@final
@dataclass(frozen=True)
class _Mapping:
    """Which of the mapped columns are taken for which, and by which factors.

    Attributes:
        readings: for each joint the index of the joint whose reading it is.
        commands: for each command the index of the command that it is.
        reading_scales: factors on the joints' readings.
        command_scales: factors on the commands.
        difference: what differs from the mapping as it is.
    """

    readings: tuple[int, ...]
    commands: tuple[int, ...]
    reading_scales: tuple[float, ...]
    command_scales: tuple[float, ...]
    difference: str = ""


def better_mappings(robot: Robot, recording: Recording) -> list[str]:
    """What of a mapping the nominal model contradicts, as sentences; none where it cannot be tested.

    Args:
        robot: with hinge and slide joints only, all of them measured by a position sensor or `qpos`.
        recording: as it was mapped.
    """
    model = robot.model
    columns = _position_columns(robot, recording)
    if columns is None or not 1 <= len(columns) <= _MOST_JOINTS or not model.nu:
        return []
    grid = np.arange(recording.time[0], recording.time[-1], model.opt.timestep)
    if len(grid) < 4 * int(_PIECE_S / model.opt.timestep):
        return []
    q = np.stack([_sampled(grid, recording.time, values) for values in columns.values()], axis=1)
    u = recording.ctrl[np.searchsorted(recording.time, grid, side="right") - 1]
    if not np.ptp(q, axis=0).all():
        return []
    names, motors = list(columns), [f"ctrl.{name}" for name in robot.command_columns()]
    wide = np.ptp(np.concatenate([q, u], axis=1), axis=0) > _TURN
    angles = [*(model.jnt_type == mujoco.mjtJoint.mjJNT_HINGE), *(_takes_angle(robot, k) for k in range(len(motors)))]
    in_degrees = {name for name, *both in zip([*names, *motors], wide, angles, strict=True) if all(both)}
    best = _Mapping(tuple(range(len(names))), tuple(range(model.nu)), (1.0,) * len(names), (1.0,) * model.nu)
    error, found = _error(model, q, u, best), list[str]()
    for _ in range(len(names)):
        others = [(_error(model, q, u, other), other) for other in _others(best, names, motors, in_degrees)]
        least, other = min(others, key=_first, default=(math.inf, best))
        if not (least < _FAR_BETTER * error and error > _NOT_EXACT):
            break
        better = f"the nominal model predicts the log {error / least:.2g} times better"
        found.append(f"{better} {other.difference}: check this")
        best, error = replace(other, difference=""), least
    return found


def _takes_angle(robot: Robot, command: int) -> bool:
    """Whether a command is the target of a hinge's position servo."""
    actuator = int(actuator_of_input(robot.model)[command])
    joint = robot.joint_of_actuator(actuator)
    hinge = joint is not None and robot.model.jnt_type[joint] == mujoco.mjtJoint.mjJNT_HINGE
    return bool(hinge and position_input(robot.model, actuator) == command)


def _first(pair: tuple[float, _Mapping]) -> float:
    return pair[0]


def _position_columns(robot: Robot, recording: Recording) -> dict[str, np.ndarray] | None:
    """The position of every joint (rows,) by our column name; None if one is no scalar, or is not measured."""
    model, found = robot.model, {}
    sensors = dict(enumerate(model.sensor_type.tolist()))
    for joint, name in enumerate(robot.names("joint")):
        if joint not in robot.scalar_joints:
            return None
        own = [s for s, kind in sensors.items() if kind == mujoco.mjtSensor.mjSENS_JOINTPOS]
        own = [s for s in own if model.sensor_objid[s] == joint]
        arrays = {f"sensor.{robot.names('sensor')[s]}": recording.sensor[:, model.sensor_adr[s]] for s in own}
        arrays[f"qpos.{name}"] = recording.qpos[:, model.jnt_qposadr[joint]]
        column = next((c for c, values in arrays.items() if np.isfinite(values).sum() > 10), None)
        if column is None:
            return None
        found[column] = arrays[column]
    return found


def _sampled(grid: np.ndarray, time: np.ndarray, values: np.ndarray) -> np.ndarray:
    there = np.isfinite(values)
    return np.interp(grid, time[there], values[there])


def _others(
    now: _Mapping, readings: Sequence[str], commands: Sequence[str], in_degrees: Collection[str]
) -> Iterator[_Mapping]:
    """The mappings that differ from one by an exchange of two columns, a sign, or a unit of those that may have it."""
    for i, j in combinations(range(len(readings)), 2):
        difference = f"with {readings[i]} and {readings[j]} exchanged"
        yield replace(now, readings=_exchanged(now.readings, i, j), difference=difference)
    for i, j in combinations(range(len(commands)), 2):
        difference = f"with {commands[i]} and {commands[j]} exchanged"
        yield replace(now, commands=_exchanged(now.commands, i, j), difference=difference)
    for factor, how in ((-1.0, "scale = -1.0"), (_DEGREE, 'unit = "deg"')):
        for i, name in enumerate(readings):
            if factor < 0.0 or name in in_degrees:
                scales = _scaled(now.reading_scales, i, factor)
                yield replace(now, reading_scales=scales, difference=f"with {how} for {name}")
        for i, name in enumerate(commands):
            if factor < 0.0 or name in in_degrees:
                scales = _scaled(now.command_scales, i, factor)
                yield replace(now, command_scales=scales, difference=f"with {how} for {name}")


def _exchanged(order: tuple[int, ...], i: int, j: int) -> tuple[int, ...]:
    swapped = list(order)
    swapped[i], swapped[j] = swapped[j], swapped[i]
    return tuple(swapped)


def _scaled(scales: tuple[float, ...], i: int, factor: float) -> tuple[float, ...]:
    return tuple(factor * scale if k == i else scale for k, scale in enumerate(scales))


def _error(model: mujoco.MjModel, q: np.ndarray, u: np.ndarray, mapping: _Mapping) -> float:
    """Root mean square of the replays' errors in all joints, each over its range in the log.

    Args:
        model: the nominal one.
        q: (n, joints) positions at its steps.
        u: (n, nu) commands at its steps.
        mapping: of both.
    """
    q, u = q[:, mapping.readings] * mapping.reading_scales, u[:, mapping.commands] * mapping.command_scales
    half = max(int(_SLOPE_S / model.opt.timestep), 1)
    length = int(_PIECE_S / model.opt.timestep)
    data, spans, squares = mujoco.MjData(model), np.ptp(q, axis=0), []
    for first in np.linspace(half, len(q) - length - half - 1, _PIECES).astype(int).tolist():
        mujoco.mj_resetData(model, data)
        data.qpos[model.jnt_qposadr] = q[first]
        data.qvel[model.jnt_dofadr] = (q[first + half] - q[first - half]) / (2 * half * model.opt.timestep)
        for k in range(first, first + length):
            data.ctrl[:] = u[k]
            mujoco.mj_step(model, data)
            if k % 5 == 0:
                squares.append(np.minimum(np.square((data.qpos[model.jnt_qposadr] - q[k + 1]) / spans), 1.0))
    return float(np.sqrt(np.mean(squares)))
