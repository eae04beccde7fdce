"""Windows of recordings replayed by the C engine, with a force on the joints that no effect of the catalogue has.

All windows step together, so that the law is asked once a step for all of them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from estexp_jax.discovery.problem import Problem
from estexp_jax.physics.effects.changes import neutral, stack
from estexp_jax.physics.engines.c.motor_scales import with_switched_motors
from estexp_jax.physics.engines.open_loop import OpenLoopRollout
from estexp_jax.physics.engines.open_loop_inputs import CommandSteps, command_steps
from estexp_jax.physics.engines.open_loop_states import shows_forces
from estexp_jax.physics.window import Window

Law = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""(qpos (lanes, nq), qvel (lanes, nv), ctrl (lanes, nu), motor torque (lanes, nv)) -> force (lanes, nv), N m or N."""

_TOO_FAST = 1e6
"""Speed of a simulation that blew up; it is left alone from there on."""


Switched = dict[tuple[int, bytes], mujoco.MjModel]
"""Models with motors on or off, by the model and the switches."""


def switched(model: mujoco.MjModel, enable: np.ndarray, known: Switched) -> list[mujoco.MjModel]:
    """The model with motors on or off as in each row of `enable` (rows, nactuator); `known` has one for equal rows."""
    found = []
    for row in np.asarray(enable, float):
        key = (id(model), row.tobytes())
        if key not in known:
            known[key] = model if np.all(row == 1.0) else with_switched_motors(model, row)
        found.append(known[key])
    return found


class _Lane:
    """One window on its way.

    Args:
        model: of the window's recording.
        s: the window.
        drive: its steps, (steps, ...), and one more.
        known: models shared with other windows.
    """

    def __init__(self, model: mujoco.MjModel, s: Window, drive: CommandSteps, known: Switched) -> None:
        self.models = switched(model, drive.enable, known)
        self.length, self.ctrl = np.asarray(drive.length, float), np.asarray(drive.ctrl, float)
        self.data = mujoco.MjData(model)
        self.data.qpos[:], self.data.qvel[:], self.data.ctrl[:] = s.start.qpos, s.start.qvel, self.ctrl[0]
        mujoco.mj_forward(self.models[0], self.data)
        self.n_steps, self.row_at = s.steps.n_steps, {int(k): row for row, k in enumerate(s.steps.sample)}
        self.seen = [np.full((s.rows, n), np.nan) for n in (model.nsensordata, model.nq, model.nv)]

    def step(self, k: int, force: np.ndarray) -> None:
        """Step `k` under a force (nv,); at a row, also what is seen there."""
        data, there, row = self.data, self.models[k], self.row_at.get(k)
        data.ctrl[:], data.qfrc_applied[:] = self.ctrl[k], force
        if row is not None:
            self.seen[1][row], self.seen[2][row] = data.qpos, data.qvel
        if self.length[k] > 0.0:
            there.opt.timestep = self.length[k]
            mujoco.mj_step(there, data)
        else:
            mujoco.mj_forward(there, data)
        if row is not None:
            self.seen[0][row] = data.sensordata


def simulated_with(problem: Problem, models: Sequence[mujoco.MjModel], law: Law, windows: np.ndarray) -> np.ndarray:
    """Readings (windows, rows, channels) under a law, at the fine step; NaN beyond a window's end and once it blew up.

    Args:
        problem: the comparison.
        models: the robot in each recording; its step is changed.
        law: the force.
        windows: indices of the windows.
    """
    robot, effects = problem.replayer.robot, problem.replayer.catalogue
    segments = [problem.replays.cut.fine[w] for w in windows]
    problem.counted[0] += sum(s.steps.n_steps for s in segments)
    segments = [s.with_pauses for s in segments] if shows_forces(robot) else segments
    nothing = stack([neutral(robot, effects)] * len(segments))
    drive = command_steps(robot, effects, nothing, segments, max(s.steps.n_steps for s in segments) + 1)
    own = [models[s.recording] for s in segments]
    return problem.channels.simulated(_replay(law, own, segments, drive))


def _replay(
    law: Law,
    models: Sequence[mujoco.MjModel],
    segments: Sequence[Window],
    drive: CommandSteps,
) -> OpenLoopRollout:
    """Replay windows, each with its robot, all by the same law."""
    known: Switched = {}
    lanes = [
        _Lane(m, s, CommandSteps(*(x[..., i] for x in drive)), known)
        for i, (m, s) in enumerate(zip(models, segments, strict=True))
    ]
    going = lanes
    for k in range(max(lane.n_steps for lane in lanes) + 1):
        going = [lane for lane in going if k <= lane.n_steps and _sane(lane.data.qvel)]
        if not going:
            break
        now = (lane.data for lane in going)
        states = [(d.qpos, d.qvel, d.qfrc_actuator) for d in now]
        qpos, qvel, motor = (np.stack(column) for column in zip(*states, strict=True))
        # The motors' torque is that of the step before: the force is wanted before this one's is known.
        forces = law(qpos, qvel, np.stack([lane.ctrl[k] for lane in going]), motor)
        for lane, force in zip(going, forces, strict=True):
            lane.step(k, force)
    return OpenLoopRollout(*(_together([lane.seen[i] for lane in lanes]) for i in range(3)))


def _sane(qvel: np.ndarray) -> bool:
    return bool(np.all(np.abs(qvel) < _TOO_FAST))  # False for NaN


def _together(tables: Sequence[np.ndarray]) -> np.ndarray:
    """(lanes, most rows, columns), filled up with NaN."""
    found = np.full((len(tables), max(map(len, tables)), tables[0].shape[1]), np.nan)
    for i, table in enumerate(tables):
        found[i, : len(table)] = table
    return found
