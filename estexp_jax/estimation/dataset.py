"""Windows of recordings with what was measured in them and how far each measurement is to be trusted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import final

import numpy as np

from estexp_jax.estimation.channels import Channels
from estexp_jax.estimation.windows import windows_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import Window


@final
@dataclass(frozen=True, eq=False)
class Dataset:
    """Windows that a simulation is compared with.

    Attributes:
        recordings: all of them; windows refer to these by index.
        channels: the readings compared.
        windows: each with its initial state and commands.
    """

    recordings: tuple[Recording, ...]
    channels: Channels
    windows: tuple[Window, ...]

    @cached_property
    def measurements(self) -> np.ndarray:
        """Readings (windows, rows, channels), NaN beyond a window's end and where there is no sample.

        A recording's first row is left out: its forces belong to a command that nobody logged.
        """
        rows = max(w.rows for w in self.windows)
        found = np.full((len(self.windows), rows, len(self.channels.names)), np.nan)
        table = {r: self.channels.recorded(self.recordings[r]) for r in {w.recording for w in self.windows}}
        for i, w in enumerate(self.windows):
            found[i, : w.rows] = table[w.recording][w.first : w.last + 1]
            if w.first == 0:
                found[i, 0] = np.nan
        return found

    @cached_property
    def owner(self) -> np.ndarray:
        """Index of each window's recording, (windows,)."""
        return np.array([w.recording for w in self.windows])

    @cached_property
    def durations(self) -> np.ndarray:
        """Length of each window, (windows,) s."""
        return np.array([float(w.steps.length.sum()) for w in self.windows])

    def subset(self, chosen: Sequence[int] | np.ndarray) -> Dataset:
        """The same with some windows only."""
        return Dataset(self.recordings, self.channels, tuple(self.windows[int(i)] for i in chosen))


def dataset_of(
    robots: Sequence[Robot],
    recordings: Sequence[Recording],
    channels: Channels,
    length: float,
    roles: str = "train",
    memory: float = np.inf,
) -> Dataset:
    """All windows of one length of the recordings of a role.

    Args:
        robots: the nominal robot with each recording's settings.
        recordings: of all roles.
        channels: the readings compared.
        length: of a window, s.
        roles: `train` or `test`.
        memory: time before a window's start that hidden variables are rolled along, s.
    """
    every = windows_of(robots, recordings, length)
    wanted = tuple(
        w if np.isinf(memory) else replace(w, memory=round(memory * recordings[w.recording].rate))
        for w in every
        if recordings[w.recording].role == roles and w.rows > 1
    )
    whole = max((w.rows for w in wanted), default=0)
    return Dataset(tuple(recordings), channels, tuple(w for w in wanted if 2 * w.rows > whole))


def evenly(dataset: Dataset, most: int) -> Dataset:
    """At most so many windows, evenly spread over all."""
    n = len(dataset.windows)
    return dataset if n <= most else dataset.subset(np.linspace(0, n - 1, most).round().astype(int))
