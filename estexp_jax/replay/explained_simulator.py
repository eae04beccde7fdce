"""The simulator that an explanation gives back: the nominal one with what it lacked, also what MJCF cannot say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, final

import mujoco
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import Change, Values, encode, stack
from estexp_jax.physics.effects.registry import catalogue, named_effects
from estexp_jax.physics.effects.written import written
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.open_loop import OpenLoopRollout, OpenLoopSimulator, RowController
from estexp_jax.physics.model.clearance import ROWS, TOGETHER, without_collisions
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, Window, window_of
from estexp_jax.runs import enable_compilation_cache, forget_programs


class Traces(NamedTuple):
    """What a simulated robot did; rows as commanded."""

    time: np.ndarray  #: (rows,) s
    sensors: np.ndarray  #: (rows, nsensordata) readings, taken before the row's command acts
    qpos: np.ndarray  #: (rows, nq)
    qvel: np.ndarray  #: (rows, nv)


@final
@dataclass(frozen=True, eq=False)
class ExplainedSimulator:
    """A robot's simulator with changes in it.

    Attributes:
        robot: the nominal robot.
        changes: how the real one differs.
        finer: part of the robot's own step at which it is simulated.
    """

    robot: Robot
    changes: tuple[Change, ...]
    finer: int = 1

    @property
    def spec(self) -> mujoco.MjSpec:
        """A description, at the robot's own step, with the changes for which MuJoCo has an element."""
        return written(self.robot, self.changes)

    def rollout(
        self,
        commands: np.ndarray,
        *,
        period: float = 0.01,
        enable: np.ndarray | None = None,
        start: InitialState | None = None,
    ) -> Traces:
        """Simulate commands.

        Args:
            commands: (rows, nu), each held for one period.
            period: s.
            enable: (rows, nactuator) 1.0 where the motor is on; None: always.
            start: state to start from; None: home, at rest.

        Raises:
            InputError: `commands` has not one column for each input of an actuator, or fewer than two rows.
        """
        model = self.robot.model
        commands = np.asarray(commands, float)
        if commands.ndim != 2 or commands.shape[1] != model.nu or len(commands) < 2:
            raise InputError(f"commands are {commands.shape}", where="rollout", right=f"give (rows >= 2, {model.nu})")
        rows = len(commands)
        switched = np.ones((rows, model.nactuator)) if enable is None else np.asarray(enable, float)
        window = self._window(commands, switched, period, start)
        replay = self._simulated(window, lambda player, values: player.replay(values, [window], np.array([0])))
        return Traces(window.history.time, replay.sensors[0], replay.qpos[0], replay.qvel[0])

    def steered(self, controller: RowController, rows: int, *, period: float = 0.01) -> tuple[Traces, np.ndarray]:
        """Simulate from home, at rest, with a controller in the loop.

        Args:
            controller: gives each row's commands (nu,) from its time (s) and the true state, qpos (nq,) and qvel (nv,).
            rows: at least two.
            period: s between rows.

        Returns:
            What the robot did, and its commands (rows, nu).

        Raises:
            InputError: fewer than two rows.
        """
        if rows < 2:
            raise InputError(f"{rows} rows are no motion", where="steered", right="2 or more")
        nothing, on = np.zeros((rows, self.robot.model.nu)), np.ones((rows, self.robot.model.nactuator))
        window, given = self._window(nothing, on, period, None), [nothing]

        def play(player: OpenLoopSimulator, values: Values) -> OpenLoopRollout:
            found, given[0] = player.steered(values, window, controller)
            return found

        replay = self._simulated(window, play, int(np.diff(window.steps.sample).max()) + 1)
        return Traces(window.history.time, replay.sensors[0], replay.qpos[0], replay.qvel[0]), given[0]

    def _window(self, commands: np.ndarray, enable: np.ndarray, period: float, start: InitialState | None) -> Window:
        model, rows = self.robot.model, len(commands)
        sensor, qpos, qvel = (np.full((rows, n), np.nan) for n in (model.nsensordata, model.nq, model.nv))
        recording = Recording("rollout", period * np.arange(rows), commands, enable, sensor, qpos, qvel)
        begin = InitialState(self.robot.home(), np.zeros(model.nv)) if start is None else start
        return window_of([recording], 0, (0, rows - 1), float(model.opt.timestep) / self.finer, begin)

    def _simulated(
        self, window: Window, play: Callable[[OpenLoopSimulator, Values], OpenLoopRollout], block: int | None = None
    ) -> OpenLoopRollout:
        """One motion, without contacts that do not occur in it: engines lack contacts of meshes, or are slow with them.

        Contacts of parts that do not meet at the start are left out first; those that do meet later are put back.
        """
        enable_compilation_cache()
        forget_programs()
        effects = catalogue(dict.fromkeys(change.effect for change in self.changes))
        if not effects:
            effects = named_effects()[:1]  # a catalogue needs one; it stays neutral
        values = stack([encode(self.robot, effects, self.changes)])
        near = TOGETHER + 2.0 * float(self.robot.model.geom_margin.max(initial=0.0))
        left_out = without_collisions(self.robot, [np.asarray(window.start.qpos, float)[None]], near)
        while True:
            robot = self.robot.without_contacts(left_out)
            replay = play(open_loop_simulator(robot, effects, [robot], width=1, block=block), values)
            path = replay.qpos[0].astype(float)
            path = path[np.isfinite(path).all(axis=1)]
            far = without_collisions(self.robot, [path[i : i + ROWS] for i in range(0, len(path), ROWS)], near)
            if set(left_out) <= set(far):
                return replay
            left_out = [pair for pair in left_out if pair in far]
