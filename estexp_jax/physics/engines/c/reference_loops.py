"""Closed loops over MuJoCo's C engine, as fast as Python drives it: what the batch engines are measured against.

All robots here are the nominal one, each with its own controller. Four ways: one robot at a time, with its controller
or replaying commands (`SerialSimulator`); all on a thread pool, open loop (`OpenLoopPool`, `mujoco.rollout`) or closed
loop (`PooledSimulator`, `mujoco.batch`).
"""

from __future__ import annotations

import abc
from dataclasses import dataclass, field
from functools import partial
from typing import Any, final

import mujoco
import mujoco.rollout
import numpy as np

from estexp_jax.physics.engines.batching import cores
from estexp_jax.physics.engines.c.batches import new_batch
from estexp_jax.physics.engines.controller_interface import Interface
from estexp_jax.physics.engines.policy import Policy

_BUFFER = 4_000_000
"""Numbers in the buffer that `mujoco.rollout` fills before it is used again; larger ones are slower."""


@final
@dataclass(frozen=True, eq=False)
class StartState:
    """The state in which all robots start.

    Attributes:
        qpos, qvel, warmstart: (nq,), (nv,), (nv,); the last one is the solver's.
        sensordata: (nsensordata,) of the step before.
    """

    qpos: np.ndarray
    qvel: np.ndarray
    warmstart: np.ndarray
    sensordata: np.ndarray

    def into(self, data: mujoco.MjData) -> None:
        """Put a robot into this state."""
        data.qpos[:], data.qvel[:], data.qacc_warmstart[:] = self.qpos, self.qvel, self.warmstart
        data.sensordata[:], data.time = self.sensordata, 0.0


def at_rest(model: mujoco.MjModel, qpos: np.ndarray, ctrl: np.ndarray, seconds: float) -> StartState:
    """A robot after some time with one command (nu,) in force, from a configuration (nq,)."""
    data = mujoco.MjData(model)
    data.qpos[:], data.ctrl[:] = qpos, ctrl
    mujoco.mj_step(model, data, max(1, round(seconds / model.opt.timestep)))
    return StartState(*(np.array(x) for x in (data.qpos, data.qvel, data.qacc_warmstart, data.sensordata)))


@final
class BatchedControllers:
    """The healthy controllers of many robots (n, ...), or of one of them, between sensors and motors."""

    def __init__(self, policy: Policy, weights: np.ndarray, face: Interface) -> None:
        """For weights (n, n_weights), or (n_weights,) for one robot."""
        self._policy, self._face = policy.on_host(weights, face.n_inputs, face.n_outputs), face
        self._touch = np.flatnonzero(face.is_touch)
        self._angle = np.flatnonzero(~face.is_touch)
        self._columns, self._qpos = face.columns[self._touch], face.qpos[self._angle]
        self._centre, self._scale = face.centre[self._angle], face.scale[self._angle]

    def commands(self, qpos: np.ndarray, sensordata: np.ndarray) -> np.ndarray:
        """Commands (..., nu) from configurations (..., nq) and readings (..., nsensordata) of the last step."""
        face, inputs = self._face, self._policy.inputs
        inputs[..., self._touch] = np.where(sensordata[..., self._columns] > 0.0, 1.0, -1.0)
        angles = (qpos[..., self._qpos] - self._centre) / self._scale
        inputs[..., self._angle] = np.minimum(np.maximum(angles, -1.0), 1.0)
        outputs = self._policy.respond()
        return np.minimum(np.maximum(face.ctrl_centre + face.ctrl_scale * outputs, face.ctrl_low), face.ctrl_high)


class CSimulator(abc.ABC):
    """A way to simulate robots with the C engine."""

    @abc.abstractmethod
    def rollout(self, robots: int, steps: int) -> np.ndarray:
        """Simulate the first robots for some control steps.

        Returns:
            (robots, nq) where they end.
        """


@final
@dataclass(frozen=True, eq=False)
class CRollouts:
    """Inputs that all simulators share.

    Attributes:
        model: the nominal robot.
        face: of its controllers.
        policy: the controllers' equations.
        start: where all begin.
        weights: (n, n_weights).
        substeps: physics steps a control step.
    """

    model: mujoco.MjModel
    face: Interface
    policy: Policy
    start: StartState
    weights: np.ndarray
    substeps: int


@final
@dataclass(frozen=True, eq=False)
class SerialSimulator(CSimulator):
    """One robot at a time, `mj_step` from Python.

    Attributes:
        course: the shared inputs.
        recorded: (n, steps, nu) commands to replay; None: the controllers give them.
    """

    course: CRollouts
    recorded: np.ndarray | None = None

    def rollout(self, robots: int, steps: int) -> np.ndarray:
        """See `CSimulator`."""
        data = mujoco.MjData(self.course.model)
        one = self._driven if self.recorded is None else self._replayed
        return np.array([one(data, i, steps) for i in range(robots)])

    def _driven(self, data: mujoco.MjData, robot: int, steps: int) -> np.ndarray:
        course = self.course
        course.start.into(data)
        model, n, ctrl, qpos, sensordata = course.model, course.substeps, data.ctrl, data.qpos, data.sensordata
        controller = BatchedControllers(course.policy, course.weights[robot], course.face)
        for _ in range(steps):
            ctrl[:] = controller.commands(qpos, sensordata)
            mujoco.mj_step(model, data, n)
        return qpos.copy()

    def _replayed(self, data: mujoco.MjData, robot: int, steps: int) -> np.ndarray:
        course, rows = self.course, self.recorded
        assert rows is not None  # chosen by `rollout`
        course.start.into(data)
        model, n, ctrl = course.model, course.substeps, data.ctrl
        for row in rows[robot, :steps]:
            ctrl[:] = row
            mujoco.mj_step(model, data, n)
        return data.qpos.copy()


@final
@dataclass(frozen=True, eq=False)
class PooledSimulator(CSimulator):
    """All robots on all cores with their controllers in the loop: `mujoco.batch.Batch`."""

    course: CRollouts
    _batches: dict[int, Any] = field(default_factory=dict, init=False)

    def rollout(self, robots: int, steps: int) -> np.ndarray:
        """See `CSimulator`."""
        return self._rollout(robots, steps, None)

    def record(self, robots: int, steps: int) -> np.ndarray:
        """The commands (robots, steps, nu) that the controllers give."""
        rows = np.zeros((robots, steps, self.course.model.nu))
        self._rollout(robots, steps, rows)
        return rows

    def _rollout(self, robots: int, steps: int, rows: np.ndarray | None) -> np.ndarray:
        course, start = self.course, self.course.start
        if robots not in self._batches:
            self._batches.clear()
            self._batches[robots] = new_batch(course.model, robots, nthread=cores())
        batch = self._batches[robots]
        state = {name: batch.bind(name) for name in ("qpos", "qvel", "qacc_warmstart", "ctrl", "sensordata")}
        state["qpos"][:], state["qvel"][:], state["qacc_warmstart"][:] = start.qpos, start.qvel, start.warmstart
        sensordata = np.broadcast_to(start.sensordata, (robots, len(start.sensordata)))
        controllers = BatchedControllers(course.policy, course.weights[:robots], course.face)
        for row in range(steps):
            ctrl = controllers.commands(state["qpos"], sensordata)
            state["ctrl"][:] = ctrl
            if rows is not None:
                rows[:, row] = ctrl
            batch.step(nstep=course.substeps)
            sensordata = state["sensordata"]
        return state["qpos"].copy()


@final
@dataclass(frozen=True, eq=False)
class OpenLoopPool(CSimulator):
    """All robots on all cores, replaying commands: `mujoco.rollout`.

    Attributes:
        course: the shared inputs.
        recorded: (n, steps, nu) commands.
    """

    course: CRollouts
    recorded: np.ndarray
    _pool: Any = field(default_factory=lambda: mujoco.rollout.Rollout(nthread=cores()), init=False)

    def rollout(self, robots: int, steps: int) -> np.ndarray:
        """See `CSimulator`; in pieces, so that what it must record (every state) stays in a small buffer."""
        course, model, full = self.course, self.course.model, mujoco.mjtState.mjSTATE_FULLPHYSICS
        size = partial(mujoco.mj_stateSize, model)
        data = mujoco.MjData(model)
        course.start.into(data)
        first = np.zeros(size(full))
        mujoco.mj_getState(model, data, first, full)
        states: Any = np.tile(first, (robots, 1))
        warm: Any = np.tile(course.start.warmstart, (robots, 1))
        width = len(first) + model.nsensordata
        piece = int(np.clip(_BUFFER // (robots * width * course.substeps), 1, steps))
        threads = [mujoco.MjData(model) for _ in range(cores())]
        for row in range(0, steps, piece):
            rows = np.repeat(self.recorded[:robots, row : min(row + piece, steps)], course.substeps, axis=1)
            found: Any = self._pool.rollout(model, threads, states, rows, initial_warmstart=warm)[0]
            states, warm = found[:, -1], None
        return states[:, 1 : 1 + model.nq].copy()
