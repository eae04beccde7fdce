"""Open loop, whatever the engine: recorded commands replayed through many hypothetical robots at once.

A lane is one hypothesis on one window of a recording. Lanes are replayed in chunks, one thread a core. An engine that
compiles advances chunks of equal width by blocks of equal length, so that one executable serves every replay.
"""

from __future__ import annotations

import abc
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from typing import Any, ClassVar, NamedTuple

import numpy as np

from estexp_jax.physics.command_schedule import CommandHistory
from estexp_jax.physics.effects.base import CommandLaw, Term
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.engines.batching import EngineChoice, cores
from estexp_jax.physics.engines.mjx.terms import stateful
from estexp_jax.physics.engines.open_loop_inputs import (
    CommandSteps,
    RolledRows,
    add_drift,
    command_routes,
    command_steps,
    delay_readings,
    initial_states,
    instances_with,
    rolled_rows,
)
from estexp_jax.physics.engines.open_loop_states import LaneBatchState, StepReadings, at_rows, shows_forces
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.window import Window

_ROLL = 256
"""Rows in one call that hidden variables are rolled along."""
RowController = Callable[[float, np.ndarray, np.ndarray], np.ndarray]
"""(time in s, qpos (nq,), qvel (nv,)) of a row -> commands (nu,), held until the next one."""


class OpenLoopRollout(NamedTuple):
    """Lanes at the rows of their windows, NaN beyond a window's end.

    Attributes:
        sensors: (lanes, rows, nsensordata) readings, faults applied.
        qpos: (lanes, rows, nq).
        qvel: (lanes, rows, nv).
    """

    sensors: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray


@dataclass(frozen=True, eq=False)
class OpenLoopSimulator(abc.ABC):
    """Replays recordings through hypotheses about a robot.

    Attributes:
        robot: the nominal robot.
        catalogue: the effects that values have an entry for.
        width: lanes in a chunk.
        block: physics steps in a call.
        choice: which engine it is, and why.
    """

    robot: Robot
    catalogue: Catalogue
    width: int
    block: int
    choice: EngineChoice

    #: Precision of states, commands and readings.
    dtype: ClassVar[type[np.floating]] = np.float32

    @abc.abstractmethod
    def _prepared(self, values: Values, windows: Sequence[Window]) -> Any:
        """Constants of all blocks; a window for each lane."""

    @abc.abstractmethod
    def _rested(self, prepared: Any, roll: RolledRows) -> Any:
        """Hidden variables of robots that have been where they are, a row of a roll, for long."""

    @abc.abstractmethod
    def _rolled(self, prepared: Any, hidden: Any, roll: RolledRows) -> Any:
        """Hidden variables after the rows of a roll, along which robots moved as recorded."""

    @abc.abstractmethod
    def _advanced(
        self, prepared: Any, state: LaneBatchState, drive: CommandSteps
    ) -> tuple[LaneBatchState, StepReadings]:
        """Whole blocks of steps: the state after them, and what was seen at the beginning of each."""

    @property
    def left_out(self) -> tuple[str, ...]:
        """What of the robot is not simulated; each follows "simulated without"."""
        return ()

    def _chunk_size(self, n: int, n_steps: int) -> int:
        """Lanes that are replayed together, of `n` in all with windows of at most so many steps."""
        return self.width

    def _filled_up(self, lanes: np.ndarray) -> np.ndarray:
        """The lanes of a chunk, and as many of them again as fill it up to its width."""
        return np.resize(lanes, self.width)

    def replay(self, values: Values, windows: Sequence[Window], which: np.ndarray) -> OpenLoopRollout:
        """Replay lanes.

        Args:
            values: (lanes, n_sites, n_parameters) for each effect.
            windows: those that can be replayed.
            which: (lanes,) index of each lane's window.
        """
        which, windows = np.asarray(which), self._read(windows)
        remembers = instances_with(self.robot, stateful(self.catalogue), values)
        order = np.lexsort([which, self._at_work(values, which), [windows[w].steps.n_steps for w in which]])
        size = self._chunk_size(len(which), max(windows[w].steps.n_steps for w in which))
        chunks = [order[i : i + size] for i in range(0, len(order), size)]

        def run(lanes: np.ndarray) -> OpenLoopRollout:
            chosen = self._filled_up(lanes)
            part = {name: np.asarray(v, np.float32)[chosen] for name, v in values.items()}
            here = [windows[w] for w in which[chosen]]
            return self._chunk(part, here, len(lanes), remembers=bool(remembers[lanes].any()))

        with ThreadPoolExecutor(cores()) as threads:
            parts = list(threads.map(run, chunks))
        rows = max(windows[w].rows for w in which)
        return OpenLoopRollout(*(self._gather(parts, chunks, field, rows) for field in OpenLoopRollout._fields))

    def _gather(self, parts: list[OpenLoopRollout], chunks: list[np.ndarray], field: str, rows: int) -> np.ndarray:
        whole = np.full((sum(map(len, chunks)), rows, getattr(parts[0], field).shape[2]), np.nan, self.dtype)
        for part, lanes in zip(parts, chunks, strict=True):
            found = getattr(part, field)
            whole[lanes, : found.shape[1]] = found
        return whole

    def _chunk(self, values: Values, windows: list[Window], n: int, *, remembers: bool) -> OpenLoopRollout:
        """Replay a chunk's lanes, keep the first `n`; if none remembers, what came before the start does not matter."""
        n_steps = max(s.steps.n_steps for s in windows) + 1  # one more to read the last row
        blocks = -(-n_steps // self.block)
        drive = command_steps(self.robot, self.catalogue, values, windows, blocks * self.block, self.dtype)
        prepared, state = self._started(values, windows, remembers=remembers)
        _, outputs = self._advanced(prepared, state, drive)
        return self._at_rows(outputs, values, windows, n)

    def _read(self, windows: Sequence[Window]) -> Sequence[Window]:
        """Windows with steps in which all sensors of the robot can be read at the rows."""
        return [s.with_pauses for s in windows] if shows_forces(self.robot) else windows

    def steered(self, values: Values, window: Window, controller: RowController) -> tuple[OpenLoopRollout, np.ndarray]:
        """Replay one lane from its start under a controller's commands instead of recorded ones; for a `width` of 1.

        Args:
            values: (1, n_sites, n_parameters) for each effect.
            window: from its recording's first row on, each row of fewer than `block` steps; its commands do not count.
            controller: gives each row's commands.

        Returns:
            The robot's rollout, and its commands (rows, nu).
        """
        values = {name: np.asarray(v, np.float32) for name, v in values.items()}
        (window,) = self._read([window])
        prepared, state = self._started(values, [window], remembers=False)
        steps, time = window.steps, window.history.time
        delay, source = command_routes(self.robot, self.catalogue, values)
        rows: list[np.ndarray] = []
        outputs: list[StepReadings] = []
        for row in range(window.rows):
            rows.append(np.asarray(controller(float(time[row]), *(np.asarray(x[0], float) for x in state[:2])), float))
            last = row + 1 == window.rows
            own = slice(steps.sample[row], steps.n_steps if last else steps.sample[row + 1])
            history, count = CommandHistory(time[: row + 1], np.array(rows)), own.stop - own.start
            drive = self._row_steps(window, row, own, lambda t, dt, of=history: of.mean(t, dt, delay[0], source[0]))
            state, part = self._advanced(prepared, state, drive)
            outputs.append(StepReadings(*(x[: count + last] for x in part)))
        commands = np.array(rows)
        whole = StepReadings(*(np.concatenate(kind) for kind in zip(*outputs, strict=True)))
        played = replace(window, history=window.history.with_commands(commands))
        return self._at_rows(whole, values, [played], 1), commands

    def _row_steps(
        self, window: Window, row: int, own: slice, commands: Callable[[np.ndarray, np.ndarray], np.ndarray]
    ) -> CommandSteps:
        """Steps of one row of one lane, filled up to a block by some without length."""
        count, enable = own.stop - own.start, np.tile(window.enable[row], (self.block, 1))
        begin, span, length = np.full(self.block, window.history.time[row]), np.zeros(self.block), np.zeros(self.block)
        begin[:count], span[:count] = (x[own] for x in window.steps.command_spans())
        length[:count], enable[:count] = window.steps.length[own], window.switched_on[own]
        return CommandSteps(*(np.asarray(x, self.dtype)[..., None] for x in (length, commands(begin, span), enable)))

    def _started(self, values: Values, windows: list[Window], *, remembers: bool) -> tuple[Any, LaneBatchState]:
        """Constants of all blocks, and the initial state of lanes."""
        model, n = self.robot.model, len(windows)
        prepared = self._prepared(values, windows)
        qpos, qvel = initial_states(self.robot, self.catalogue, values, windows, self.dtype)
        act, warmstart = (np.zeros((n, k), self.dtype) for k in (model.na, model.nv))
        state = LaneBatchState(qpos, qvel, act, warmstart, {})
        if stateful(self.catalogue):
            state = state._replace(hidden=self._hidden(prepared, values, windows, remembers=remembers))
        return prepared, state

    def _at_rows(self, outputs: StepReadings, values: Values, windows: list[Window], n: int) -> OpenLoopRollout:
        """The first `n` lanes at their rows, from all steps, with the delay and drift of sensors."""
        delay_readings(self.robot, self.catalogue, outputs.sensors, values, windows)
        add_drift(self.robot, self.catalogue, outputs.sensors, values, windows)
        rows = max(s.rows for s in windows[:n])
        return OpenLoopRollout(*(at_rows(x, windows[:n], rows) for x in outputs))

    def _hidden(self, prepared: Any, values: Values, windows: list[Window], *, remembers: bool) -> Any:
        """Hidden variables at the lanes' starts: rolled along each recording's rows before them."""
        n_rows = max(s.rolled for s in windows) if remembers else 0
        blocks = -(-n_rows // _ROLL)
        before = rolled_rows(self.robot, self.catalogue, values, windows, blocks * _ROLL, self.dtype)
        hidden = self._rested(prepared, RolledRows(*(x[0] for x in before)))
        for b in range(blocks):
            hidden = self._rolled(prepared, hidden, RolledRows(*(x[b * _ROLL : (b + 1) * _ROLL] for x in before)))
        return hidden

    def _at_work(self, values: Values, which: np.ndarray) -> np.ndarray:
        """Numbers (lanes,), alike for lanes that have the same terms and command laws at work."""
        acting = [e for e in self.catalogue if isinstance(e, Term | CommandLaw)]
        each = np.array([np.zeros(len(which), bool), *(instances_with(self.robot, [e], values) for e in acting)])
        return np.unique(each, axis=1, return_inverse=True)[1]
