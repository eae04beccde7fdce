"""Inputs of an open-loop rollout, lane by lane, in numpy: commands, initial states, rows before the start.

A lane is one hypothesis on one window of a recording.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

import numpy as np

from estexp_jax.physics.effects.base import CommandShift, Distortion, Effect, ReadingDrift, ReadingShift
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.controller_fault import CommandRoute
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.model.actuators import affine_actuators, gear_of, position_input
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.window import Window

_LAG = 0.04
"""Time over which commands are averaged to guess a servo's position, s: it follows with a small delay."""


class CommandSteps(NamedTuple):
    """Physics steps of lanes: (steps, ..., lanes)."""

    length: Any  # (steps, lanes)
    ctrl: Any
    enable: Any


class RolledRows(NamedTuple):
    """Rows before lanes' starts: (rows, ..., lanes)."""

    qpos: Any
    qvel: Any
    ctrl: Any
    enable: Any
    length: Any  # s; 0: not a row, but to fill up


def command_steps(
    robot: Robot,
    catalogue: Catalogue,
    values: Values,
    windows: list[Window],
    n_steps: int,
    dtype: type[np.floating] = np.float32,
) -> CommandSteps:
    """Steps of lanes, each with its own commands; beyond a window's end the last ones are held, and no time passes."""
    shifts, sources = command_routes(robot, catalogue, values)
    model, undelayed = robot.model, _undelayed(shifts, sources)
    length = np.zeros((n_steps, len(windows)), dtype)
    ctrl, enable = (np.empty((n_steps, width, len(windows)), dtype) for width in (model.nu, model.nactuator))
    for i, there in equal_commands(windows, undelayed):
        s, k = windows[i], windows[i].steps.n_steps
        length[:k, there] = s.steps.length[:, None]
        commands = s.logged if undelayed[i] else s.commands(shifts[i], sources[i])
        for whole, own in ((ctrl, commands), (enable, s.switched_on)):
            whole[:k, :, there], whole[k:, :, there] = own[..., None], own[-1][:, None]
    return CommandSteps(length, ctrl, enable)


def equal_commands(windows: Sequence[Window], undelayed: np.ndarray) -> Iterator[tuple[int, slice]]:
    """Neighbouring lanes that get the same commands: the first one, and all of them."""
    first = 0
    for i, s in enumerate(windows):
        if i + 1 == len(windows) or windows[i + 1] is not s or not (undelayed[i] and undelayed[i + 1]):
            yield first, slice(first, i + 1)
            first = i + 1


def initial_states(
    robot: Robot,
    catalogue: Catalogue,
    values: Values,
    windows: list[Window],
    dtype: type[np.floating] = np.float32,
) -> tuple[np.ndarray, np.ndarray]:
    """Initial states of lanes, (lanes, nq) and (lanes, nv): measured states with each lane's sensor faults undone."""
    qpos = np.array([s.start.qpos for s in windows], dtype)
    qvel = np.array([s.start.qvel for s in windows], dtype)
    faults = [e for e in catalogue if isinstance(e, Distortion)]
    delay = _shifts(robot, catalogue, values, ReadingShift, robot.model.nsensordata)
    drift = _drifts(robot, catalogue, values)
    faulty = delay.any(axis=1) | drift.any(axis=1) | instances_with(robot, faults, values)
    for i, s in enumerate(windows):
        if not (faulty[i] and s.start.sensed):
            continue
        for column, place, speed in s.start.sensed:
            if delay[i, column] > 0.0 and s.path is not None:  # true now is what is read later
                now, then = s.steps.start[0], s.steps.start[0] + delay[i, column]
                qpos[i, place] += s.path.at(then, s.path.qpos, place) - s.path.at(now, s.path.qpos, place)
                qvel[i, speed] += s.path.at(then, s.path.qvel, speed) - s.path.at(now, s.path.qvel, speed)
        columns, places, speeds = map(list, zip(*s.start.sensed, strict=True))
        now = np.zeros((2, robot.model.nsensordata))
        now[:, columns] = qpos[i, places]
        now[1, columns] += qvel[i, speeds]  # the reading a second later, at this speed
        now -= drift[i] * (s.steps.start[0] - s.history.time[0] + np.array([[0.0], [1.0]]))
        for effect in reversed(faults):
            now = effect.restore(robot, now, values[effect.name][i])
        blind = np.isnan(now[0, columns])
        guess, fast = _commanded_state(robot, s) if blind.any() else (robot.home(), np.zeros(robot.model.nv))
        shift = s.start.qpos - s.path.qpos[s.first] if s.path is not None else np.zeros(robot.model.nq)
        pushed = s.start.qvel - s.path.qvel[s.first] if s.path is not None else np.zeros(robot.model.nv)
        qpos[i, places] = np.where(blind, (guess + shift)[places], now[0, columns])
        qvel[i, speeds] = np.where(blind, (fast + pushed)[speeds], now[1, columns] - now[0, columns])
    return qpos, qvel


def _commanded_state(robot: Robot, s: Window) -> tuple[np.ndarray, np.ndarray]:
    """Positions (nq,) and speeds (nv,) that servos were commanded at a window's start; home, at rest, without servo.

    The best guess for a joint without readings.
    """
    model, qpos, qvel = robot.model, robot.home().copy(), np.zeros(robot.model.nv)
    begin = s.steps.start[0] - np.array([3.0, 1.0]) * _LAG / 2.0
    before, now = s.history.mean(begin, np.full(2, _LAG), np.zeros(model.nu))
    affine = affine_actuators(model)
    for a in range(model.nactuator):
        joint, gear, target = robot.joint_of_actuator(a), gear_of(model, a), position_input(model, a)
        if joint in robot.scalar_joints and target is not None and gear != 0.0:
            factor = (model.actuator_gainprm[a, 0] / -model.actuator_biasprm[a, 1] if affine[a] else 1.0) / gear
            qpos[model.jnt_qposadr[joint]] = factor * now[target]
            qvel[model.jnt_dofadr[joint]] = factor * (now[target] - before[target]) / _LAG
    return qpos, qvel


def rolled_rows(
    robot: Robot,
    catalogue: Catalogue,
    values: Values,
    windows: list[Window],
    n_rows: int,
    dtype: type[np.floating] = np.float32,
) -> RolledRows:
    """Rows before each window (n_rows + 1, ..., lanes), its own first row last; the first ones repeat."""
    shifts, sources = command_routes(robot, catalogue, values)
    undelayed, n = _undelayed(shifts, sources), n_rows + 1
    model, length = robot.model, np.zeros((n, len(windows)), dtype)
    qpos, qvel, ctrl, enable = (
        np.empty((n, width, len(windows)), dtype) for width in (model.nq, model.nv, model.nu, model.nactuator)
    )
    found = RolledRows(qpos, qvel, ctrl, enable, length)
    for i, there in equal_commands(windows, undelayed):
        past = windows[i].logged_past if undelayed[i] else windows[i].past(n, shifts[i], sources[i])
        k = min(n, len(past.length))
        for whole, own in zip(found[:-1], past[:-1], strict=True):
            whole[n - k :, :, there], whole[: n - k, :, there] = own[-k:, :, None], own[-k][:, None]
        length[n - k :, there] = past.length[-k:, None]
    return found


def instances_with(robot: Robot, effects: Sequence[Effect], values: Values) -> np.ndarray:
    """Which lanes (lanes,) have one of some effects at work."""
    found = np.zeros(_lanes(values), bool)
    for e in effects:
        nothing = np.array([p.neutral for p in e.parameters], np.float32)
        found |= (np.asarray(values[e.name], np.float32) != nothing).any(axis=(1, 2))
    return found


def command_routes(robot: Robot, catalogue: Catalogue, values: Values) -> tuple[np.ndarray, np.ndarray]:
    """Delay of each lane's commands (s) and the address of the one in its place, (lanes, nu) each."""
    return _shifts(robot, catalogue, values, CommandShift, robot.model.nu), _sources(robot, catalogue, values)


def _undelayed(shifts: np.ndarray, sources: np.ndarray) -> np.ndarray:
    """Which lanes (lanes,) get their commands as they were logged."""
    return ~shifts.any(axis=1) & (sources == np.arange(sources.shape[1])).all(axis=1)


def delay_readings(
    robot: Robot, catalogue: Catalogue, sensors: np.ndarray, values: Values, windows: list[Window]
) -> None:
    """Replace, in place, the readings (steps, nsensordata, lanes) of delayed sensors by older ones.

    A delayed sensor first shows states from before the start; these are taken as recorded.
    """
    delay = _shifts(robot, catalogue, values, ReadingShift, robot.model.nsensordata)
    for i, column in np.argwhere(delay > 0.0).tolist():
        s, n = windows[i], windows[i].steps.n_steps
        time = np.append(s.steps.start, s.steps.end)
        read = np.interp(time - delay[i, column], time, sensors[: n + 1, column, i])
        for sensed, place, _ in s.start.sensed:
            if sensed == column and s.path is not None:
                before = time - delay[i, column] < time[0]
                read[before] = s.path.at(time[before], s.path.qpos, place)
        sensors[: n + 1, column, i] = read


def add_drift(robot: Robot, catalogue: Catalogue, sensors: np.ndarray, values: Values, windows: list[Window]) -> None:
    """Add, in place, to the readings (steps, nsensordata, lanes) their drift since the recordings began."""
    drift = _drifts(robot, catalogue, values)
    for i in np.flatnonzero(drift.any(axis=1)).tolist():
        steps = windows[i].steps
        age = np.append(steps.start, steps.end) - windows[i].history.time[0]
        sensors[: len(age), :, i] += age[:, None] * drift[i]


def _drifts(robot: Robot, catalogue: Catalogue, values: Values) -> np.ndarray:
    """Drift of each lane's readings per second, (lanes, nsensordata)."""
    total = np.zeros((_lanes(values), robot.model.nsensordata))
    for effect in catalogue:
        if isinstance(effect, ReadingDrift):
            total += effect.rate(robot, values[effect.name])
    return total


def _shifts(
    robot: Robot, catalogue: Catalogue, values: Values, kind: type[CommandShift] | type[ReadingShift], n: int
) -> np.ndarray:
    """Delay of each lane's commands or readings, (lanes, n), s."""
    total = np.zeros((_lanes(values), n))
    for effect in catalogue:
        if isinstance(effect, CommandShift | ReadingShift) and isinstance(effect, kind):
            total += effect.shift(robot, values[effect.name])
    return total


def _sources(robot: Robot, catalogue: Catalogue, values: Values) -> np.ndarray:
    """Address of the command that stands in each command's place, (lanes, nu)."""
    source = np.tile(np.arange(robot.model.nu), (_lanes(values), 1))
    for effect in catalogue:
        if isinstance(effect, CommandRoute):
            other = effect.route(robot, values[effect.name])
            source = np.where(other >= 0, other, source)
    return source


def _lanes(values: Values) -> int:
    return next(iter(values.values())).shape[0]
