"""Windows replayed by nothing but MuJoCo: a model with all that was found in it, stepped by `mj_step`.

The model may have more joints, motors and memory than the robot. What it remembers (delayed commands and readings,
activations, bristles, rotors) is made by rolling it along the recorded path before a window.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import replace
from typing import Any, final

import mujoco
import numpy as np

from estexp_jax.physics.command_schedule import physics_steps
from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.effects.registry import catalogue
from estexp_jax.physics.effects.written import carried_over, joint_addresses, same_joints
from estexp_jax.physics.engines.c.motor_scales import with_switched_motors
from estexp_jax.physics.engines.open_loop import OpenLoopRollout
from estexp_jax.physics.engines.open_loop_inputs import initial_states
from estexp_jax.physics.engines.open_loop_states import shows_forces
from estexp_jax.physics.model.actuators import inputs_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.validation import mujoco_warnings_suppressed
from estexp_jax.physics.window import Window

_ROLLED = 2.0
"""Time before a window along which the model is rolled at most, s."""
Stepper = Callable[[mujoco.MjModel, mujoco.MjData, np.ndarray], Any]
"""Takes one step of a model's length, given which motors (nactuator,) are on."""
_TOO_FAST = 1e6
"""Speed of a simulation that blew up."""


@final
class PlainReplay:
    """A model of a robot, replayed.

    Args:
        robot: the nominal robot, whose commands, states and sensors windows have.
        model: what is stepped; elements that both have go by the same names.
        begin: gives what takes steps, of the model and a state; None: MuJoCo does.
        changes: what is in the model: windows start where its faulty sensors say that the robot was.
    """

    def __init__(
        self,
        robot: Robot,
        model: mujoco.MjModel,
        begin: Callable[[mujoco.MjModel, mujoco.MjData], Stepper] | None = None,
        changes: Sequence[Change] = (),
    ) -> None:
        self._changes = tuple(changes)
        self._robot, self._model, self._begin = robot, copy(model), begin or (lambda *_: self._step)
        motors = [model.actuator(name).id for name in robot.names("actuator") if _has(model, "actuator", name)]
        own = [robot.index("actuator", model.actuator(a).name) for a in motors]
        self._motors, self._own_motors = np.array(motors, int), np.array(own, int)
        pairs = [(inputs_of(model, a), inputs_of(robot.model, o)) for a, o in zip(motors, own, strict=True)]
        self._ctrl = np.array([i for there, _ in pairs for i in there], int)
        self._own_ctrl = np.array([i for _, here in pairs for i in here], int)
        self._columns = _columns(robot, model)
        self._joints = [
            (*joint_addresses(model, j), *joint_addresses(robot.model, own))
            for j, own in same_joints(robot, model)
            if model.joint(j).name in robot.names("joint")
        ]
        self._switched: dict[bytes, mujoco.MjModel] = {}
        self._remembers = begin is not None or _remembers(robot.model, model)
        self._timestep = float(model.opt.timestep)

    def replay(self, windows: Sequence[Window]) -> OpenLoopRollout:
        """Readings and states (windows, rows, ...) of the robot's own sensors and joints; NaN once it blew up."""
        paused = shows_forces(self._robot)
        with mujoco_warnings_suppressed():
            found = [self._one(w.with_pauses if paused else w) for w in self._started(windows)]
        rows = max(w.rows for w in windows)
        tables = []
        for part in range(3):
            table = np.full((len(windows), rows, found[0][part].shape[1]), np.nan)
            for i, one in enumerate(found):
                table[i, : len(one[part])] = one[part]
            tables.append(table)
        return OpenLoopRollout(*tables)

    def _started(self, windows: Sequence[Window]) -> Sequence[Window]:
        """Windows with the initial states that go with the changes."""
        if not self._changes:
            return windows
        effects = catalogue(dict.fromkeys(c.effect for c in self._changes))
        values = stack([encode(self._robot, effects, self._changes)] * len(windows))
        initial = initial_states(self._robot, effects, values, list(windows), np.float64)
        pairs = zip(windows, *initial, strict=True)
        return [replace(w, start=w.start._replace(qpos=qpos, qvel=qvel)) for w, qpos, qvel in pairs]

    def _one(self, window: Window) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        robot, steps = self._robot, window.steps
        data, step = self._remembering(window)
        widths = robot.model.nsensordata, robot.model.nq, robot.model.nv
        sensors, qpos, qvel = (np.full((window.rows, n), np.nan) for n in widths)
        rows = {int(k): row for row, k in enumerate(steps.sample)}
        commands, on = window.logged, window.switched_on
        last = np.flatnonzero(steps.length)[-1]
        changes, switches = np.append(False, (on[1:] != on[:-1]).any(axis=1)), self._switches(on[0])
        for k in range(steps.n_steps + 1):
            now = min(k, steps.n_steps - 1)
            if changes[now]:
                switches = self._switches(on[now])
            data.ctrl[self._ctrl] = commands[now][self._own_ctrl]
            row = rows.get(k)
            if row is not None:
                for q, v, own_q, own_v in self._joints:
                    qpos[row, own_q], qvel[row, own_v] = data.qpos[q], data.qvel[v]
            if k < steps.n_steps and steps.length[k] == 0.0:
                mujoco.mj_forward(self._with_motors(switches), data)
            else:
                self._model.opt.timestep = steps.length[k] if k < steps.n_steps else steps.length[last]
                step(self._model, data, switches)
            if row is not None:
                sensors[row, self._columns[0]] = data.sensordata[self._columns[1]]
                if not np.all(np.abs(data.qvel) < _TOO_FAST):
                    break
        return sensors, qpos, qvel

    def _remembering(self, window: Window) -> tuple[mujoco.MjData, Stepper]:
        """The state at a window's start, with all that the model remembers there, and what steps it."""
        path, start, first = window.path, window.start, window.first
        time = window.history.time
        rolled = path is not None and self._remembers
        since = first if not rolled else int(np.searchsorted(time, time[first] - _ROLLED))
        qpos, qvel = (path.qpos[since], path.qvel[since]) if path is not None and rolled else (start.qpos, start.qvel)
        self._model.opt.timestep = self._timestep
        data = self._resting(window, since, qpos, qvel)
        step = self._begin(self._model, data)
        if path is not None and rolled and first > since:
            steps = physics_steps(time[since : first + 1], self._timestep)
            commands = window.history.mean(steps.start, steps.length, *_as_logged(self._robot))
            for k in range(steps.n_steps):
                fraction = (steps.start[k] - time[since + steps.row[k]]) / np.diff(time)[since + steps.row[k]]
                row = since + steps.row[k]
                self._place(data, path.qpos[row] + fraction * (path.qpos[row + 1] - path.qpos[row]), path.qvel[row])
                self._model.opt.timestep = steps.length[k]
                data.ctrl[self._ctrl] = commands[k][self._own_ctrl]
                step(self._model, data, self._switches(window.enable[row]))
        self._place(data, start.qpos, start.qvel)
        data.time = window.steps.start[0]
        return data, step

    def _step(self, model: mujoco.MjModel, data: mujoco.MjData, switches: np.ndarray) -> None:
        """One step of MuJoCo's own."""
        own = self._with_motors(switches)
        own.opt.timestep = model.opt.timestep
        mujoco.mj_step(own, data)

    def _switches(self, on: np.ndarray) -> np.ndarray:
        """Which motors of the model are on, of the robot's."""
        switches = np.ones(self._model.nactuator)
        switches[self._motors] = on[self._own_motors]
        return switches

    def _resting(self, window: Window, row: int, qpos: np.ndarray, qvel: np.ndarray) -> mujoco.MjData:
        """A robot that has been in a state, under its command, for long."""
        model, data = self._model, mujoco.MjData(self._model)
        data.qpos[:], data.qvel[:] = carried_over(self._robot, model, qpos, qvel)
        data.time = window.history.time[row]
        step = float(model.opt.timestep)
        command = window.history.mean(np.array([data.time - step]), np.array([step]), *_as_logged(self._robot))[0]
        data.ctrl[self._ctrl] = command[self._own_ctrl]
        for a in self._motors.tolist():
            inputs, filters = inputs_of(model, a), model.actuator_dyntype[a] in _FILTERS
            if filters and len(inputs) == 1:
                data.act[model.actuator_actadr[a]] = data.ctrl[inputs[0]]
            if (n := int(model.actuator_history[a, 0])) > 0:
                before = window.history.mean(
                    data.time + step * np.arange(-n, 0), np.full(n, step), *_as_logged(self._robot)
                )
                table = np.zeros((n, model.nu))
                table[:, self._ctrl] = before[:, self._own_ctrl]
                mujoco.mj_initCtrlHistory(model, data, a, data.time + step * np.arange(-n, 0), table[:, list(inputs)])
        self._fill_readings(data, qpos, qvel, command)
        return data

    def _fill_readings(self, data: mujoco.MjData, qpos: np.ndarray, qvel: np.ndarray, command: np.ndarray) -> None:
        """Let delayed sensors have read the robot's state all the time."""
        model, nominal = self._model, self._robot.model
        delayed = np.flatnonzero(model.sensor_history[:, 0] > 0)
        if not delayed.size:
            return
        there, step = mujoco.MjData(nominal), float(model.opt.timestep)
        there.qpos[:], there.qvel[:], there.ctrl[:] = qpos, qvel, command
        mujoco.mj_forward(nominal, there)
        for s in delayed.tolist():
            if (name := model.sensor(s).name) not in self._robot.names("sensor"):
                continue
            own, n = self._robot.index("sensor", name), int(model.sensor_history[s, 0])
            first = int(nominal.sensor_adr[own])
            values = np.tile(there.sensordata[first : first + int(model.sensor_dim[s])], (n, 1))
            mujoco.mj_initSensorHistory(model, data, s, data.time + step * np.arange(-n, 0), values, data.time)

    def _place(self, data: mujoco.MjData, qpos: np.ndarray, qvel: np.ndarray) -> None:
        for q, v, own_q, own_v in self._joints:
            data.qpos[q], data.qvel[v] = qpos[own_q], qvel[own_v]

    def _with_motors(self, switches: np.ndarray) -> mujoco.MjModel:
        """The model with motors on or off."""
        key = switches.tobytes()
        if key not in self._switched:
            self._switched[key] = with_switched_motors(self._model, switches)
        return self._switched[key]


_FILTERS = (int(mujoco.mjtDyn.mjDYN_FILTER), int(mujoco.mjtDyn.mjDYN_FILTEREXACT))


def _remembers(nominal: mujoco.MjModel, model: mujoco.MjModel) -> bool:
    """Whether a model's step hangs on more than the nominal robot's position, speed and command."""
    delays = (model.actuator_history[:, 0] > 0).any() or (model.sensor_history[:, 0] > 0).any()
    return bool(delays or model.na or model.nplugin or model.nv != nominal.nv)


def _as_logged(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros(robot.model.nu), np.arange(robot.model.nu)


def _has(model: mujoco.MjModel, kind: str, name: str) -> bool:
    kinds = {"actuator": mujoco.mjtObj.mjOBJ_ACTUATOR, "sensor": mujoco.mjtObj.mjOBJ_SENSOR}
    return mujoco.mj_name2id(model, kinds[kind], name) >= 0


def _columns(robot: Robot, model: mujoco.MjModel) -> tuple[np.ndarray, np.ndarray]:
    """Columns of the robot's readings, and of the model's, of the sensors that both have."""
    here, there = list[int](), list[int]()
    for s, name in enumerate(robot.names("sensor")):
        if _has(model, "sensor", name):
            n = int(robot.model.sensor_dim[s])
            here += range(int(robot.model.sensor_adr[s]), int(robot.model.sensor_adr[s]) + n)
            first = int(model.sensor_adr[model.sensor(name).id])
            there += range(first, first + n)
    return np.array(here, int), np.array(there, int)
