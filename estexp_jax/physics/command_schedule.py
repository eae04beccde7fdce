"""Physics steps of an open-loop rollout, and the commands in each step.

Physics steps never straddle a row of the log: each interval between rows is cut into equal steps, no longer than the
model's own, so that no reading is compared with the state of another time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

_ROUNDING = 1e-6
"""An interval that differs this little (relative) from whole steps counts as whole: logs round their times."""

_JUST_BEFORE = 1e-6
"""Time before a row at which its command is not yet in force, s."""
_RESTING = 0.05
"""Share of its greatest speed below which a robot counts as resting."""
_SMOOTH = 0.5
"""Change of the rise of a command from row to row, as a share of the rise, from which on it is not smooth."""


@final
@dataclass(frozen=True, eq=False)
class CommandSchedule:
    """Physics steps between rows.

    Attributes:
        start: (steps,) time at which each step begins, s.
        length: (steps,) its length, s.
        row: (steps,) index of the row whose command is in force; -1 before the first one.
        sample: (rows,) index of the step that begins at each row; without pauses, the last is one past the end.
    """

    start: np.ndarray
    length: np.ndarray
    row: np.ndarray
    sample: np.ndarray

    @property
    def n_steps(self) -> int:
        """Number of physics steps."""
        return len(self.start)

    @property
    def end(self) -> float:
        """Time at which the last step ends, s."""
        return float(self.start[-1] + self.length[-1])

    def with_pauses(self) -> CommandSchedule:
        """The same with one more step at each row, without length, in which the command before the row is in force.

        Sensors of forces and accelerations are read there: at the row's time, before its command acts.
        """
        rows, at = np.arange(len(self.sample)), self.sample
        time = np.append(self.start[at[:-1]], self.end)
        return CommandSchedule(
            np.insert(self.start, at, time),
            np.insert(self.length, at, 0.0),
            np.insert(self.row, at, rows - 1),
            at + rows,
        )

    def command_spans(self) -> tuple[np.ndarray, np.ndarray]:
        """Start and length (steps,), s, of the times whose mean command is each step's; a pause's is just before it."""
        pause = self.length == 0.0
        return np.where(pause, self.start - _JUST_BEFORE, self.start), np.where(pause, _JUST_BEFORE, self.length)


def physics_steps(row_time: np.ndarray, timestep: float) -> CommandSchedule:
    """Steps that end on every row.

    Args:
        row_time: (rows,) strictly increasing, s.
        timestep: longest step, s.
    """
    interval = np.diff(row_time)
    count = np.maximum(1, np.ceil(interval / timestep - _ROUNDING)).astype(int)
    row = np.repeat(np.arange(len(interval)), count)
    sample = np.concatenate([[0], np.cumsum(count)])
    each = interval / count
    length = np.where(np.abs(each - timestep) <= _ROUNDING * timestep, timestep, each)[row]
    within = np.arange(len(row)) - sample[row]
    return CommandSchedule(row_time[row] + within * length, length, row, sample)


@final
class CommandHistory:
    """A log's commands, held from row to row, and their mean over any span of time.

    The mean over a step is exact for a held command and continuous in a delay, so that a delay of a fraction of a row
    can be found by gradients.

    Attributes:
        time: (rows,) s.
        logged: (rows, nu) commands.
    """

    def __init__(self, time: np.ndarray, ctrl: np.ndarray, before: np.ndarray | None = None) -> None:
        """Commands `ctrl` (rows, nu) in force from `time` (rows,) on, `before` (nu,) until then; None: the first."""
        self.time, self.logged = time, ctrl
        self._before = ctrl[0] if before is None else before
        steps = np.diff(time)[:, None] * ctrl[:-1]
        self._integral = np.concatenate([np.zeros((1, ctrl.shape[1])), np.cumsum(steps, axis=0)])

    def mean(
        self, start: np.ndarray, length: np.ndarray, shift: np.ndarray, source: np.ndarray | None = None
    ) -> np.ndarray:
        """Mean command (steps, nu) over [start - shift, start - shift + length].

        After the last row its command counts.

        Args:
            start: (steps,) s.
            length: (steps,) s.
            shift: (nu,) s, delay of each command.
            source: (nu,) whose command each motor gets; None: its own.
        """
        own = np.arange(self.logged.shape[1]) if source is None else source
        row = np.searchsorted(self.time, start, side="right") - 1
        held = np.where(row[:, None] < 0, self._before, self.logged[np.clip(row, 0, None)])[:, own]
        delayed = np.flatnonzero(shift)
        for a in delayed.tolist():
            begin = start - shift[a]
            span = np.maximum(length, 1e-9)
            held[:, a] = (self._area(begin + span, own[a]) - self._area(begin, own[a])) / span
        return held

    def with_commands(self, ctrl: np.ndarray) -> CommandHistory:
        """The same with other commands (rows, nu)."""
        return CommandHistory(self.time, ctrl, self._before)

    def _area(self, when: np.ndarray, actuator: int) -> np.ndarray:
        first, last = self.time[0], self.time[-1]
        inside = np.interp(when, self.time, self._integral[:, actuator])
        before = np.minimum(when - first, 0.0) * self._before[actuator]
        return inside + before + np.maximum(when - last, 0.0) * self.logged[-1, actuator]


def command_before(ctrl: np.ndarray, qvel: np.ndarray) -> np.ndarray:
    """The command (nu,) in force until the first row, which the log does not hold.

    A robot that moves at the first row was cut out of a longer motion: where its commands continue smoothly, they
    are extrapolated back by one row. A robot at rest is taken to have had the first row's command.

    Args:
        ctrl: (rows, nu).
        qvel: (rows, nv) estimated speeds.
    """
    moving = np.linalg.norm(qvel[0]) > _RESTING * np.linalg.norm(qvel, axis=1).max()
    if len(ctrl) < 3 or not moving:
        return ctrl[0]
    first, second = ctrl[1] - ctrl[0], ctrl[2] - ctrl[1]
    return np.where(np.abs(second - first) < _SMOOTH * np.abs(first), ctrl[0] - first, ctrl[0])
