"""What a joint fit explains, and its windows."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import final

import numpy as np

from estexp_jax.estimation.channels import Channels, channel_ranges
from estexp_jax.estimation.dataset import Dataset, dataset_of
from estexp_jax.estimation.parameters import Place
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.reading_noise import noise_std_of
from estexp_jax.physics.recording import Recording


@final
@dataclass(frozen=True, eq=False)
class JointProblem:
    """What the joint fit explains.

    Attributes:
        robots: the nominal robot with each recording's settings.
        recordings: with their roles; only training ones are used.
        channels: the readings compared.
        simulator: of the robot and the catalogue.
        places: what may be claimed.
        known: places whose values are given for each recording.
        observed: what recordings show of joints and sensors.
        lacking: share of the error of the simulator's step that the robot lacks.
        counted: robot steps simulated so far, a list of one number.
    """

    robots: Sequence[Robot]
    recordings: tuple[Recording, ...]
    channels: Channels
    simulator: OpenLoopSimulator
    places: Collection[Place]
    known: Collection[Place]
    observed: Observed
    lacking: float = 1.0
    counted: list[int] = field(default_factory=lambda: [0])

    def dataset(self, length: float, memory: float) -> Dataset:
        """All windows of a length of the training recordings, both in s as of `dataset_of`; each is cut once."""
        if (length, memory) not in self._datasets:
            cut = dataset_of(self.robots, self.recordings, self.channels, length, memory=memory)
            self._datasets[length, memory] = cut
        return self._datasets[length, memory]

    @cached_property
    def least_noise(self) -> np.ndarray:
        """Noise (channels,) of the readings: the median of the training recordings'."""
        train = [r for r in self.recordings if r.role == "train"]
        recorded = [self.channels.recorded(r) for r in train]
        each = [[noise_std_of(r.time, c) for c in table.T] for r, table in zip(train, recorded, strict=True)]
        spans = [channel_ranges(self.channels, r) for r in train]
        return np.fmax(np.nanmedian(np.array(each), axis=0), 1e-5 * np.nanmedian(np.array(spans), axis=0))

    @cached_property
    def _datasets(self) -> dict[tuple[float, float], Dataset]:
        return {}
