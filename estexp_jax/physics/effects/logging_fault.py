"""What goes wrong when a log is written: the robot does as it should, and its log says something else.

No simulation holds such an effect. It is decided before anything is searched, from the recordings alone or by replays
of the nominal model; recordings that show it are put right, and only then is physics looked for.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import ClassVar, NamedTuple

import numpy as np

from estexp_jax.physics.effects.effect import Effect
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_SAME = 1e-3
"""Share of a log's period by which two times differ at most that count as one."""


class Suspicion(NamedTuple):
    """A fault of logging that a recording may have."""

    site: str
    values: tuple[float, ...]  #: of its parameters, in their order


class LoggingFault(Effect):
    """Acts between the robot and its log: what happened -> what was written down."""

    kind: ClassVar[str] = "recording"
    side: ClassVar[str] = "sensor"
    #: Whether its first parameter is sought between the values that are tried.
    is_continuous: ClassVar[bool] = False
    #: Whether it makes clocks of commands and readings disagree.
    displaces_time: ClassVar[bool] = False

    @abc.abstractmethod
    def logged(self, robot: Robot, recording: Recording, site: str, values: Mapping[str, float]) -> Recording:
        """The log with the fault, of one without."""

    @abc.abstractmethod
    def mended(self, robot: Robot, recording: Recording, site: str, values: Mapping[str, float]) -> Recording:
        """The log without the fault, of one with it."""

    def tried(self, robot: Robot, site: str, recording: Recording) -> Vectors:
        """Values at which a recording is mended and replayed, to see whether it has the fault."""
        return []

    def tried_beside_physics(self, robot: Robot, site: str, recording: Recording) -> Vectors:
        """Values at which it is tried with ordinary physics free, where that alone cannot explain a log.

        Physics that the model lacks may hide it, as dry friction delays what early stamps advance.
        """
        return []

    def tried_together(self, robot: Robot) -> Sequence[tuple[Suspicion, ...]]:
        """Several of it at once that are as likely as a single one."""
        return ()

    def plain(self, robot: Robot, site: str, recording: Recording) -> Mapping[str, float] | None:
        """Its values where a recording shows it without any simulation; None where it does not."""
        return None

    def looks_like_physics(self, site: str) -> bool:
        """Whether friction, inertia and strength together move a robot just so: then only the fault alone tells."""
        return False

    def is_undone(self, values: Mapping[str, float]) -> bool:
        """Whether a recording is put right at these values before physics is looked for."""
        return True

    def values_of(self, vector: Sequence[float]) -> dict[str, float]:
        """Parameter name to value, of values in the order of `parameters`."""
        return {p.name: float(v) for p, v in zip(self.parameters, vector, strict=True)}


def with_commands_at(recording: Recording, times: np.ndarray) -> Recording:
    """A recording whose command of each row was in force from another time on.

    Rows are put in, without readings, where commands now change between rows: at half periods of an even clock.

    Args:
        recording: the log.
        times: (rows,) s, increasing: when each row's command came into force.
    """
    even = is_even(recording)
    grid = recording.time
    if even:
        half = 0.5 * float(np.median(np.diff(grid)))
        times = grid[0] + np.round((times - grid[0]) / half) * half
        snapped = np.round((grid - grid[0]) / half).astype(int)
        moved = np.round((times - grid[0]) / half).astype(int)
        between = np.setdiff1d(moved, snapped)
        between = between[(between > snapped[0]) & (between < snapped[-1])]
        added = grid[0] + between * half
    else:
        changed = np.append(True, np.any(np.diff(recording.ctrl, axis=0) != 0.0, axis=1))
        added = np.setdiff1d(times[changed], grid)
        added = added[(added > grid[0]) & (added < grid[-1])]
    same = _SAME * float(np.median(np.diff(grid)))
    nearest = np.abs(added[:, None] - grid[np.clip(np.searchsorted(grid, added)[:, None] + (-1, 0), 0, len(grid) - 1)])
    time = np.sort(np.concatenate([grid, added[nearest.min(axis=1, initial=np.inf) > same]]))
    time = time[np.append(True, np.diff(time) > same)]
    own = np.searchsorted(grid, time, side="right") - 1
    is_new = grid[own] != time
    rows = np.clip(np.searchsorted(times, time + same, side="right") - 1, 0, len(times) - 1)

    def known(table: np.ndarray) -> np.ndarray:
        return np.where(is_new[:, None], np.nan, table[own])

    return replace(
        recording,
        time=time,
        ctrl=recording.ctrl[rows],
        enable=recording.enable[rows],
        sensor=known(recording.sensor),
        qpos=known(recording.qpos),
        qvel=known(recording.qvel),
        guessed=None if recording.guessed is None else recording.guessed[own],
    )


def is_even(recording: Recording) -> bool:
    """Whether rows follow each other evenly, but for a few lost ones, and each has readings."""
    steps = np.diff(recording.time)
    period = float(np.median(steps))
    return float(np.mean(np.abs(steps - period) < 0.05 * period)) > 0.9
