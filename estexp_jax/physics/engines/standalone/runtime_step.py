"""Steps of MuJoCo with what was found in it: the fourth part of every `explained.py`, for NumPy."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import mujoco
import numpy as np

from estexp_jax.physics.engines.standalone.runtime import Found, Simulated, index_of
from estexp_jax.physics.engines.standalone.runtime_laws import Step
from estexp_jax.physics.engines.standalone.runtime_memory import CommandMemory, Memory, ReadingMemory
from estexp_jax.physics.engines.standalone.runtime_sites import Carried, Motion, carried

_FIELDS = {"damping": "dof_damping", "friction": "dof_frictionloss", "inertia": "dof_armature"}


class Explained:
    """A robot, or a batch of robots, with what was found in it.

    The model is edited when this is made. What acts during a step is taken back after it: whatever else writes
    commands, forces or values of the model finds them as it left them.
    """

    def __init__(self, found: Found, model: mujoco.MjModel, data: Any) -> None:
        self.found, self.robot = found, Simulated(model, data)
        self.indices: dict[tuple[str, str], int] = {}
        self.robot.edit(found.edits)
        self.reset()

    def reset(self) -> None:
        """Forget what was: the robot has been where it is for long."""
        commands = {k: CommandMemory(c.delay) for k, c in enumerate(self.found.delayed) if c.delay > 0.0}
        readings = {k: ReadingMemory(r.delay) for k, r in enumerate(self.found.readings) if r.delay > 0.0}
        self.memory = Memory({}, commands, readings)

    def step(self, on: Any = None) -> np.ndarray:
        """One step of the model's length.

        Args:
            on: (..., nactuator) 1.0 where a motor is on; None: all are.

        Returns:
            Readings (..., nsensordata) of its beginning, as MuJoCo's; of one robot, `sensordata` has them, too.
        """
        robot, n = self.robot, self.found.substeps
        length, found = float(robot.model.opt.timestep), list[np.ndarray]()
        with np.errstate(all="ignore"):
            for _ in range(n):
                began = self.memory.time
                self._substep(length / n, on)
                found.append(self._faulty(self._displayed(), began))
        if robot.batch is None:
            robot["sensordata"][:] = found[0]
        return found[0]

    def _substep(self, dt: float, on: Any) -> None:
        robot, memory, model = self.robot, self.memory, self.robot.model
        undo = list[tuple[np.ndarray, Any, Any]]()

        def put(array: np.ndarray, where: Any, value: Any) -> None:
            undo.append((array, where, np.array(array[where])))
            array[where] = value

        given = np.array(robot["ctrl"])
        ctrl = self._arrived(given, dt)
        switches = np.ones(model.nactuator) if on is None else np.asarray(on, float)
        now = Motion(
            np.array(robot["qpos"]), np.array(robot["qvel"]), ctrl.copy(), switches, dt, self._carried, self._centres
        )
        step = Step(np, model, robot.read, self.found, now, self.indices)
        memory.hidden = memory.hidden or step.rest()
        memory.hidden = step.act(memory.hidden)
        for k in range(model.nu):
            ctrl[..., k] = step.ctrl.get(k, ctrl[..., k])
        put(robot["ctrl"], ..., ctrl)
        for dof, force in step.added["force"].items():
            put(robot["qfrc_applied"], (..., dof), robot["qfrc_applied"][..., dof] + force)
        for part, name in _FIELDS.items():
            for dof, more in step.added[part].items():
                put(robot.own(name), (..., dof), robot.read(name)[..., dof] + more)
                if part == "inertia" and model.dof_simplenum[dof] > 0:  # MuJoCo takes its inertia from there
                    put(robot.own("dof_M0"), (..., dof), robot.read("dof_M0")[..., dof] + more)
        for body, pull in step.pull.items():
            for axis, force in enumerate(pull):
                where = (..., body, axis)
                put(robot["xfrc_applied"], where, robot["xfrc_applied"][where] + force)
        self._scale_motors(step, switches, put)
        self._move(dt)
        for array, where, value in reversed(undo):
            array[where] = value
        memory.time += dt

    def _displayed(self) -> np.ndarray:
        """Readings, with the hidden variables that sensors show."""
        readings = np.array(self.robot["sensordata"])
        for s in self.found.displayed:
            readings[..., self._column(s.sensor, s.part)] += s.factor * self.memory.hidden[s.law, s.place][s.state]
        return readings

    def _move(self, dt: float) -> None:
        """One step of MuJoCo's own of this length."""
        robot = self.robot
        if robot.batch is not None:
            length = robot.own("opt.timestep")
            before, length[:] = length.copy(), dt
            robot.step()
            length[:] = before
            return
        before, robot.model.opt.timestep = robot.model.opt.timestep, dt
        robot.step()
        robot.model.opt.timestep = before

    def _scale_motors(self, step: Step, on: np.ndarray, put: Any) -> None:
        """Gain, bias and force range together, so that limits scale with the force; what is off gives none."""
        robot, model = self.robot, self.robot.model
        plain = (int(mujoco.mjtGain.mjGAIN_FIXED), int(mujoco.mjtGain.mjGAIN_AFFINE))
        for a in range(model.nactuator):
            if a not in step.share and np.all(on[..., a] == 1.0):
                continue
            if int(model.actuator_gaintype[a]) not in plain:
                put(robot.own("actuator_forcelimited"), (..., a), 1)
                put(robot.own("actuator_forcerange"), (..., a, slice(None)), 0.0)
                continue
            scale = np.asarray(step.scale(a))[..., None]
            for name in ("actuator_gainprm", "actuator_biasprm"):
                put(robot.own(name), (..., a, slice(None)), robot.read(name)[..., a, :] * scale)
            share = np.asarray(step.share.get(a, 1.0))[..., None]
            limits = robot.own("actuator_forcerange")
            put(limits, (..., a, slice(None)), limits[..., a, :] * share)

    def _arrived(self, given: np.ndarray, dt: float) -> np.ndarray:
        """The commands that arrive now."""
        found, model = np.array(given), self.robot.model
        for k, c in enumerate(self.found.delayed):
            own = _command(model, c.motor, c.part)
            u = given[..., _command(model, c.source, c.source_part) if c.source else own]
            memory = self.memory.commands.get(k)
            found[..., own] = u if memory is None else memory.arriving(self.memory.time, dt, np.array(u))
        return found

    def _faulty(self, readings: np.ndarray, began: float) -> np.ndarray:
        for k, r in enumerate(self.found.readings):
            column = self._column(r.sensor, r.part)
            value = r.gain * readings[..., column] + r.bias
            if k in self.memory.readings:
                value = self.memory.readings[k].arriving(began, value)
            readings[..., column] = value + r.drift * began
        return readings

    def _column(self, sensor: str, part: int) -> int:
        return int(self.robot.model.sensor_adr[index_of(self.robot.model, "sensor", sensor)]) + part

    def _carried(self) -> Carried:
        return carried(np, self.robot.model, *self.robot.place("crb", "cdof", "subtree_com", "xpos"))

    def _centres(self) -> np.ndarray:
        return self.robot.place("xipos")[0]


def _command(model: mujoco.MjModel, motor: str, part: int) -> int:
    return int(model.actuator_ctrladr[index_of(model, "actuator", motor)]) + part


_INSTALLED: dict[int, Explained] = {}


def installed(found: Found, model: mujoco.MjModel, data: Any) -> Explained:
    """Begin: the model is edited once, what is remembered is forgotten."""
    there = _INSTALLED.get(id(data))
    if there is not None and there.robot.data is data and there.robot.model is model:
        there.reset()
        return there
    others = [e.found for e in _INSTALLED.values() if e.robot.model is model and not hasattr(data, "expand")]
    own = replace(others[0], edits=()) if others else found.over(model)
    _INSTALLED[id(data)] = Explained(own, model, data)
    return _INSTALLED[id(data)]


def stepped(model: mujoco.MjModel, data: Any, on: Any = None) -> np.ndarray:
    """One step of what was installed; readings of its beginning.

    Raises:
        KeyError: nothing was.
    """
    return _INSTALLED[id(data)].step(on)
