"""Readings of recordings, cut into windows, and the yardstick that what is simulated differs from them by."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.estimation.accuracy import nrmse
from estexp_jax.estimation.channels import Channels, channel_ranges
from estexp_jax.estimation.noise import median, noise_std
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.reading_noise import noise_std_of
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import Window

_LOUDEST = 3.0
"""Factor by which noise may be louder than it seems in a reading."""
_LEAST_SHARE = 5e-4
"""Of a channel's range in a recording, or in the usual training recording: no simulator is right to more."""


def deviations(channels: Channels, recordings: Sequence[Recording]) -> np.ndarray:
    """`Recorded.noise` of recordings: what sensors add, and what no simulator gets right.

    A small motion is simulated no more exactly than a large one of the same robot, and must not outweigh all of these.
    """
    span = np.array([channel_ranges(channels, recording) for recording in recordings])
    train = span[[recording.role == "train" for recording in recordings]]
    usual = np.array([median(column) for column in train.T])
    noise = [
        [noise_std_of(recording.time, column) for column in channels.recorded(recording).T] for recording in recordings
    ]
    return np.hypot(np.nan_to_num(noise), _LEAST_SHARE * np.fmax(span, usual))


@final
@dataclass(frozen=True, eq=False)
class Recorded:
    """Readings in windows.

    Attributes:
        recordings: what was recorded.
        channels: the readings compared.
        segments: the windows.
        noise: (recordings, channels) deviation that counts as one, in the channel's unit; NaN where it has no sample.
        rough: (windows, rows, channels) what counts as noise besides, or None.
    """

    recordings: tuple[Recording, ...]
    channels: Channels
    segments: tuple[Window, ...]
    noise: np.ndarray
    rough: np.ndarray | None

    def readings(self, windows: np.ndarray) -> np.ndarray:
        """Readings (windows, rows, channels), NaN beyond a window's end and where there is no sample."""
        rows = max(self.segments[w].rows for w in windows)
        found = np.full((len(windows), rows, len(self.channels.names)), np.nan)
        for i, w in enumerate(windows):
            s = self.segments[w]
            found[i, : s.rows] = self.channels.recorded(self.recordings[s.recording])[s.first : s.last + 1]
        return found

    def compared(self, windows: np.ndarray) -> np.ndarray:
        """`readings` without the first row of each recording: its forces belong to a command that nobody logged."""
        found = self.readings(windows)
        found[[self.segments[w].first == 0 for w in windows], 0] = np.nan
        return found

    def samples(self, windows: np.ndarray) -> np.ndarray:
        """Number of samples (windows,) that are compared."""
        return np.isfinite(self.compared(windows)).sum(axis=(1, 2))

    def error_of(self, simulated: np.ndarray, windows: np.ndarray) -> float:
        """The nrmse of any readings (windows, rows, channels) on windows; infinite if one of them is no number."""
        shares = self.shares_of(simulated, windows)
        if not np.isfinite(shares[np.isfinite(self.readings(windows))]).all():
            return float("inf")
        owner = np.array([self.segments[w].recording for w in windows])
        return nrmse([shares[owner == r].reshape(-1, shares.shape[2]) for r in np.unique(owner)])

    def shares_of(self, simulated: np.ndarray, windows: np.ndarray) -> np.ndarray:
        """Squared errors over squared ranges (windows, rows, channels) of any readings, NaN without a sample."""
        return ((simulated - self.readings(windows)) / self.span(windows)[:, None, :]) ** 2

    def span(self, windows: np.ndarray) -> np.ndarray:
        """Ranges of the readings in each window's recording (windows, channels), 1 where there are none."""
        each = {
            r: channel_ranges(self.channels, self.recordings[r]) for r in {self.segments[w].recording for w in windows}
        }
        return np.nan_to_num(np.array([each[self.segments[w].recording] for w in windows]), nan=1.0)

    def deviation(self, windows: np.ndarray, rows: int) -> np.ndarray:
        """What counts as one (windows, rows, channels), or (windows, 1, channels) where rows are alike."""
        noise = np.nan_to_num(self.noise[[self.segments[w].recording for w in windows]], nan=1.0)[:, None, :]
        return noise if self.rough is None else np.hypot(noise, self.rough[windows, :rows])


def observed_of(recordings: Sequence[Recording], segments: Sequence[Window]) -> Observed:
    """Where joints were and what sensors showed in the training recordings."""
    train = {i for i, r in enumerate(recordings) if r.role == "train"}
    paths = {s.recording: s.path for s in segments if s.recording in train and s.path is not None}
    qpos = np.concatenate([p.qpos for p in paths.values()])
    readings = np.concatenate([recordings[i].sensor for i in paths])
    known = np.isfinite(readings).any(axis=0)
    usual = np.full(readings.shape[1], np.nan)
    usual[known] = np.nanmedian(readings[:, known], axis=0)
    return Observed(qpos.min(axis=0), qpos.max(axis=0), usual)


def louder_noise(noise: np.ndarray, recordings: Sequence[int], difference: np.ndarray) -> np.ndarray:
    """Noise (recordings, channels) as loud as differences (windows, rows, channels) in windows of these recordings."""
    found = noise.copy()
    for recording in set(recordings):
        own = np.array([r == recording for r in recordings])
        found[recording] = np.fmax(found[recording], np.fmin(noise_std(difference[own]), _LOUDEST * found[recording]))
    return found
