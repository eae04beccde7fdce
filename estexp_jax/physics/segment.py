"""A stretch of a recording to replay: rows, the steps between them, and the state it starts from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from estexp_jax.physics.recording import Recording
from estexp_jax.physics.schedule import CommandHistory, Schedule, schedule


class Start(NamedTuple):
    """A state to start from, and what of it is only known through sensors.

    Attributes:
        qpos, qvel: (nq,), (nv,).
        sensed: (address in `sensordata`, address in qpos, address in qvel) of each joint whose position a sensor gave;
            a hypothesis that doubts the sensor starts elsewhere.
        covariance: (nv, 2, 2) of each degree of freedom's position (in the tangent space) and speed, as far as the
            state was measured with noise; None: it is exact.
    """

    qpos: np.ndarray
    qvel: np.ndarray
    sensed: tuple[tuple[int, int, int], ...] = ()
    covariance: np.ndarray | None = None


@final
@dataclass(frozen=True, eq=False)
class Path:
    """Where a recording's sensors say that the robot was, at each row.

    Attributes:
        time: (rows,) s.
        qpos, qvel: (rows, nq), (rows, nv); at home, at rest, what nothing measured.
    """

    time: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray

    def at(self, when: np.ndarray, table: np.ndarray, column: int) -> np.ndarray:
        """A column of `qpos` or `qvel` at other times; beyond the ends the last value counts."""
        return np.interp(when, self.time, table[:, column])


@final
@dataclass(frozen=True, eq=False)
class Segment:
    """Rows `first` to `last` (inclusive) of a recording.

    Attributes:
        recording: index of the recording among those replayed together.
        first, last: rows.
        steps: physics steps between the rows.
        history: the whole recording's commands, for what arrives late.
        enable: (rows of the recording, nu).
        start: the state it starts from.
        path: where the robot was in the whole recording, for what remembers it; None: at rest before the start.
    """

    recording: int
    first: int
    last: int
    steps: Schedule
    history: CommandHistory
    enable: np.ndarray
    start: Start
    path: Path | None = None

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.last - self.first + 1


def segment(
    recordings: Sequence[Recording],
    index: int,
    rows: tuple[int, int],
    timestep: float,
    start: Start,
    path: Path | None = None,
) -> Segment:
    """The stretch `rows` (first, last) of `recordings[index]`."""
    recording, (first, last) = recordings[index], rows
    steps = schedule(recording.time[first : last + 1], timestep)
    history = CommandHistory(recording.time, recording.ctrl)
    return Segment(index, first, last, steps, history, recording.enable, start, path)
