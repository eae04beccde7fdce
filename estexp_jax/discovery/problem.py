"""The comparison that all hypotheses are put to: windows of recordings, replayed and subtracted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, final

import numpy as np

from estexp_jax.discovery.hypotheses import Hypothesis, batch
from estexp_jax.discovery.starts import Seen
from estexp_jax.inference.accuracy import nrmse
from estexp_jax.inference.channels import Channels, spans
from estexp_jax.physics.engines.replaying import Replayer
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.segment import Segment

Member = tuple[Hypothesis, np.ndarray]
"""A hypothesis with a vector (n_free,) of its parameters."""

_BLOWN_UP = 10.0
"""Normalised error of a simulation that is no longer a number: worse than any that stays on its scale."""
_MOST_LANES = 4096
"""Lanes replayed together, to bound memory."""


@final
@dataclass(frozen=True, eq=False)
class Problem:
    """Recordings cut into windows, and the simulator to replay them.

    Attributes:
        replayer: of the robot and the catalogue.
        recordings: what was recorded.
        segments: the windows, at the model's own step.
        fine: the same windows at a fraction of it, standing for the time that a robot does not cut into steps.
        channels: the readings compared.
        counted: robot steps simulated so far, a list of one number.
        correction: (windows, rows, channels) what the coarse step changes, found at one member by `corrected_at`; added
            to everything simulated, because a step of some milliseconds alone may look like friction or delay.
        memory: the state of each stage of fitting, plain numbers and arrays by its name: kept by the caller, it lets an
            interrupted explanation go on where it was.
    """

    replayer: Replayer
    recordings: tuple[Recording, ...]
    segments: tuple[Segment, ...]
    fine: tuple[Segment, ...]
    channels: Channels
    counted: list[int]
    memory: dict[str, Any]
    correction: np.ndarray | None = None

    def windows_of(self, recordings: Sequence[int]) -> np.ndarray:
        """Indices of the windows of some recordings."""
        return np.array([i for i, s in enumerate(self.segments) if s.recording in recordings], dtype=int)

    def corrected_at(self, member: Member) -> Problem:
        """The same comparison, with the error of the coarse step taken out as it is for one member."""
        windows = np.arange(len(self.segments))
        pair = [self._replayed([member], windows, segments)[0] for segments in (self.fine, self.segments)]
        return replace(self, correction=np.nan_to_num(pair[0] - pair[1]))

    def simulated(self, members: Sequence[Member], windows: np.ndarray) -> np.ndarray:
        """Readings (members, windows, rows, channels) with the correction, NaN beyond a window's end."""
        found = self._replayed(members, windows, self.segments)
        return found if self.correction is None else found + self.correction[windows, : found.shape[2]]

    def exact(self) -> Problem:
        """The same comparison at the fine step, without correction: slow, and right for every member."""
        return replace(self, segments=self.fine, correction=None)

    def _replayed(self, members: Sequence[Member], windows: np.ndarray, segments: Sequence[Segment]) -> np.ndarray:
        found = []
        step = max(1, _MOST_LANES // len(windows))
        for begin in range(0, len(members), step):
            part = members[begin : begin + step]
            values = batch(self.replayer.robot, self.replayer.catalogue, part)
            lanes = {name: np.repeat(v, len(windows), axis=0) for name, v in values.items()}
            replay = self.replayer.replay(lanes, segments, np.tile(windows, len(part)))
            found.append(self.channels.simulated(replay).reshape(len(part), len(windows), -1, len(self.channels.names)))
        self.counted[0] += len(members) * sum(segments[w].steps.n_steps for w in windows)
        return np.concatenate(found)

    @cached_property
    def seen(self) -> Seen:
        """Where joints were and what sensors showed in the training recordings, for where to start."""
        train = {i for i, r in enumerate(self.recordings) if r.role == "train"}
        paths = {s.recording: s.path for s in self.segments if s.recording in train and s.path is not None}
        qpos = np.concatenate([p.qpos for p in paths.values()])
        readings = np.concatenate([self.recordings[i].sensor for i in paths])
        known = np.isfinite(readings).any(axis=0)
        median = np.full(readings.shape[1], np.nan)
        median[known] = np.nanmedian(readings[:, known], axis=0)
        return Seen(qpos.min(axis=0), qpos.max(axis=0), median)

    def recorded(self, windows: np.ndarray) -> np.ndarray:
        """Readings (windows, rows, channels), NaN beyond a window's end and where there is no sample."""
        rows = max(self.segments[w].rows for w in windows)
        found = np.full((len(windows), rows, len(self.channels.names)), np.nan)
        for i, w in enumerate(windows):
            s = self.segments[w]
            found[i, : s.rows] = self.channels.recorded(self.recordings[s.recording])[s.first : s.last + 1]
        return found

    def residuals(self, members: Sequence[Member], windows: np.ndarray) -> np.ndarray:
        """Normalised differences (members, windows, rows, channels): their squares sum to nrmse^2 over the windows.

        0 where there is no sample. A simulation that blew up counts as off by ten times the channel's range.
        """
        recorded, scale = self.recorded(windows), self._scale(windows)
        difference = (self.simulated(members, windows) - recorded) * scale[:, None, :]
        sampled = np.isfinite(recorded)
        limit = _BLOWN_UP * scale[:, None, :] * self._span(windows)[:, None, :]
        bounded = np.clip(np.nan_to_num(difference, nan=np.inf, posinf=np.inf), -limit, limit)
        return np.where(sampled, bounded, 0.0).astype(np.float32)

    def error(self, member: Member, windows: np.ndarray) -> float:
        """The nrmse of one hypothesis on windows."""
        recorded, span = self.recorded(windows), self._span(windows)
        squares = ((self.simulated([member], windows)[0] - recorded) / span[:, None, :]) ** 2
        owner = np.array([self.segments[w].recording for w in windows])
        return nrmse([squares[owner == r].reshape(-1, squares.shape[2]) for r in np.unique(owner)])

    def _span(self, windows: np.ndarray) -> np.ndarray:
        each = {r: spans(self.channels, self.recordings[r]) for r in {self.segments[w].recording for w in windows}}
        return np.nan_to_num(np.array([each[self.segments[w].recording] for w in windows]), nan=1.0)

    def _scale(self, windows: np.ndarray) -> np.ndarray:
        """(windows, channels): 1 / (range sqrt(samples of the channel in the recording's windows, times parts))."""
        sampled = np.isfinite(self.recorded(windows)).sum(axis=1)
        owner = np.array([self.segments[w].recording for w in windows])
        total = np.array([sampled[owner == r].sum(axis=0) for r in owner])
        parts = sum(int((sampled[owner == r].sum(axis=0) > 0).sum()) for r in np.unique(owner))
        return 1.0 / (self._span(windows) * np.sqrt(np.maximum(total, 1) * parts))
