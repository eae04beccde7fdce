"""A window of a recording: its rows, the physics steps between them, and its initial state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple, final

import numpy as np

from estexp_jax.physics.command_schedule import CommandHistory, CommandSchedule, command_before, physics_steps
from estexp_jax.physics.recording import Recording

_SHORTEST = 1e-3
"""Shortest time that a command of a past row is the mean of, s."""


class InitialState(NamedTuple):
    """A state to start from, and what of it is only known through sensors.

    Attributes:
        qpos, qvel: (nq,), (nv,).
        sensed: (address in `sensordata`, address in qpos, address in qvel) of each joint whose position a sensor gave;
            a hypothesis with a fault of that sensor starts elsewhere.
        covariance: (nv, 2, 2) of each degree of freedom's position (in the tangent space) and speed, as far as the
            state was measured with noise; None: it is exact.
    """

    qpos: np.ndarray
    qvel: np.ndarray
    sensed: tuple[tuple[int, int, int], ...] = ()
    covariance: np.ndarray | None = None


class PastRows(NamedTuple):
    """Rows of a recording up to a window's first row, that one last.

    Attributes:
        qpos, qvel: (rows, nq), (rows, nv).
        ctrl: (rows, nu).
        enable: (rows, nactuator).
        length: (rows,) time until the next of these rows, s; of the last one 0.
    """

    qpos: np.ndarray
    qvel: np.ndarray
    ctrl: np.ndarray
    enable: np.ndarray
    length: np.ndarray


@final
@dataclass(frozen=True, eq=False)
class StateEstimate:
    """States estimated from a recording's sensors, one for each row.

    Attributes:
        time: (rows,) s.
        qpos, qvel: (rows, nq), (rows, nv); home and at rest where nothing was measured.
    """

    time: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray

    def at(self, when: np.ndarray, table: np.ndarray, column: int) -> np.ndarray:
        """A column of `qpos` or `qvel` at other times; beyond the ends the last value counts."""
        return np.interp(when, self.time, table[:, column])


@final
@dataclass(frozen=True, eq=False)
class Window:
    """Rows `first` to `last` (inclusive) of a recording.

    Attributes:
        recording: index of the recording among those replayed together.
        first, last: rows.
        steps: physics steps between the rows.
        history: the whole recording's commands, for delayed ones.
        enable: (rows of the recording, nactuator).
        start: the state it starts from.
        path: states in the whole recording, for effects with hidden variables; None: at rest before the start.
        memory: most rows before its first one that hidden variables are rolled along; None: all.
    """

    recording: int
    first: int
    last: int
    steps: CommandSchedule
    history: CommandHistory
    enable: np.ndarray
    start: InitialState
    path: StateEstimate | None = None
    memory: int | None = None

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.last - self.first + 1

    @property
    def rolled(self) -> int:
        """Number of rows before its first one that hidden variables are rolled along."""
        known = self.first if self.path is not None else 0
        return known if self.memory is None else min(known, self.memory)

    def stepped(self, timestep: float) -> Window:
        """The same at another step, s."""
        return replace(self, steps=physics_steps(self.history.time[self.first : self.last + 1], timestep))

    @cached_property
    def with_pauses(self) -> Window:
        """The same with a step without length at each row, as `CommandSchedule.with_pauses`."""
        return replace(self, steps=self.steps.with_pauses())

    def commands(self, shift: np.ndarray, source: np.ndarray) -> np.ndarray:
        """Commands (steps, nu) in each step, as `CommandHistory.mean`."""
        return self.history.mean(*self.steps.command_spans(), shift, source)

    @cached_property
    def logged(self) -> np.ndarray:
        """`commands` as they were logged."""
        return self.commands(*self._as_logged())

    @cached_property
    def switched_on(self) -> np.ndarray:
        """Which motors were on (steps, nactuator) in each step."""
        return self.enable[np.maximum(self.first + self.steps.row, 0)]

    def past(self, rows: int, shift: np.ndarray, source: np.ndarray) -> PastRows:
        """At most so many rows, with commands as `CommandHistory.mean`; where no path is known, only the start."""
        path = self.path or StateEstimate(self.steps.start[:1], self.start.qpos[None], self.start.qvel[None])
        known = self.first + 1 if self.path is not None else 1
        at = np.arange(max(known - rows, 0), known)
        length = np.append(np.diff(path.time[at]), 0.0)
        ctrl = self.history.mean(path.time[at], np.maximum(length, _SHORTEST), shift, source)
        return PastRows(path.qpos[at], path.qvel[at], ctrl, self.enable[at + self.first + 1 - known], length)

    @property
    def logged_past(self) -> PastRows:
        """All of `past`, with commands as they were logged; not kept, since windows of a long recording are many."""
        if self.path is None:
            return self.past(1, *self._as_logged())
        path, k = self.path, self.first + 1
        length = np.append(np.diff(path.time[:k]), 0.0)
        return PastRows(path.qpos[:k], path.qvel[:k], self.history.logged[:k], self.enable[:k], length)

    def _as_logged(self) -> tuple[np.ndarray, np.ndarray]:
        n = self.history.logged.shape[1]
        return np.zeros(n), np.arange(n)


def window_of(
    recordings: Sequence[Recording],
    index: int,
    rows: tuple[int, int],
    timestep: float,
    start: InitialState,
    path: StateEstimate | None = None,
    history: CommandHistory | None = None,
) -> Window:
    """The window `rows` (first, last) of `recordings[index]`; its `command_history_of` may be passed in."""
    recording, (first, last) = recordings[index], rows
    steps = physics_steps(recording.time[first : last + 1], timestep)
    history = command_history_of(recording, path) if history is None else history
    return Window(index, first, last, steps, history, recording.enable, start, path)


def command_history_of(recording: Recording, path: StateEstimate | None = None) -> CommandHistory:
    """The commands of a recording, extrapolated to before its start if the robot moved then."""
    before = None if path is None else command_before(recording.ctrl, path.qvel)
    return CommandHistory(recording.time, recording.ctrl, before)
