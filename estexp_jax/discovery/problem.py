"""The comparison that all hypotheses are put to: windows of recordings, replayed and subtracted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, final

import mujoco
import numpy as np

from estexp_jax.discovery.doubt import directions, other_starts, whitened
from estexp_jax.discovery.hypotheses import Hypothesis, Place, lanes
from estexp_jax.discovery.slack import Slack
from estexp_jax.discovery.starts import Seen
from estexp_jax.inference.accuracy import nrmse
from estexp_jax.inference.channels import Channels, spans
from estexp_jax.inference.noise import correlation_rows, loudness, noise_deviation
from estexp_jax.physics.engines.replaying import Replayer
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.segment import Segment

Member = tuple[Hypothesis, np.ndarray]
"""A hypothesis with a vector (n_free,) of its parameters."""

_BLOWN_UP = 10.0
"""Normalised error of a simulation that is no longer a number: worse than any that stays on its scale."""
_MOST_LANES = 4096
"""Lanes replayed together, to bound memory."""
_FAR = 1e6
"""Deviations; further is a simulation that blew up."""
_LEAST_SHARE = 5e-4
"""Of a channel's range: no simulator is right to more."""


def deviations(channels: Channels, recordings: Sequence[Recording]) -> np.ndarray:
    """`Problem.noise` of recordings: what sensors add, and what no simulator gets right."""
    found = []
    for recording in recordings:
        table, span = channels.recorded(recording), spans(channels, recording)
        noise = np.array([noise_deviation(recording.time, table[:, c]) for c in range(table.shape[1])])
        found.append(np.sqrt(np.nan_to_num(noise) ** 2 + (_LEAST_SHARE * span) ** 2))
    return np.array(found)


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
        noise: (recordings, channels) deviation that counts as one, in the channel's unit; NaN where it has no sample.
        places: what may be claimed.
        step: (windows, rows, channels) what no steps at all would change, found at one member by `about`; added to
            everything simulated, because a step of some milliseconds alone may look like friction or delay.
        own: the same for hypotheses at whose fits it was found by `corrected`: a coarse step distorts dry friction and
            stops otherwise than free motion.
        lacking: share of it that the robot lacks: 1 for real ones, less for one that was simulated itself.
        most: so many windows are fitted at most.
        began: index of a recording to the time before which nothing that is claimed acts in it, s.
        doubt: directions and factors of `doubt.directions` for each window, found by `about` too.
        slack: what values of the model and earlier claims would explain, if they were fitted; None: they are not.
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
    noise: np.ndarray
    places: tuple[Place, ...]
    step: np.ndarray | None = None
    own: Mapping[Hypothesis, np.ndarray] = field(default_factory=dict)
    lacking: float = 1.0
    doubt: tuple[np.ndarray, np.ndarray] | None = None
    slack: Slack | None = None
    most: int = 48
    began: Mapping[int, float] = field(default_factory=dict)

    def windows_of(self, recordings: Sequence[int]) -> np.ndarray:
        """Indices of the windows of some recordings."""
        return np.array([i for i, s in enumerate(self.segments) if s.recording in recordings], dtype=int)

    def about(self, member: Member) -> Problem:
        """The same comparison with what one member shows: the error of the coarse step, and of uncertain starts."""
        coarse, [step] = self._steps([member])
        return replace(self, step=self._spread(step), own={}, doubt=self._doubt(member, coarse[0]))

    def corrected(self, members: Sequence[Member]) -> Problem:
        """The same comparison, in which each of these hypotheses is corrected by the step's error at its own fit."""
        _, steps = self._steps(members)
        found = {h: self._spread(step) for (h, _), step in zip(members, steps, strict=True)}
        return replace(self, own={**self.own, **found})

    def _steps(self, members: Sequence[Member]) -> tuple[np.ndarray, np.ndarray]:
        """Readings of fitted windows (members, windows, rows, channels), and what no steps at all would change."""
        fine, coarse = (self._replayed(members, self.fitted, segments) for segments in (self.fine, self.segments))
        return coarse, np.nan_to_num(fine - coarse) * self._whole

    def _spread(self, x: np.ndarray) -> np.ndarray:
        """An array of fitted windows (windows, ...) among all windows, 0 for others."""
        whole = np.zeros((len(self.segments), *x.shape[1:]), x.dtype)
        whole[self.fitted] = x
        return whole

    def price_of(self, windows: np.ndarray) -> float:
        """Price of a model's value being off by an ordinary error: that of one sample a deviation off, all costing 1.

        So weighs a normal prior of that deviation against as many independent samples.
        """
        return 1.0 / max(float(self.samples(windows).sum()), 1.0)

    def prices(self, members: Sequence[Member]) -> list[float]:
        """What an unusual value of the model costs beside each fit of the fitted windows.

        Where a hypothesis leaves more than noise, or what lasts for many rows, less can be read from the data, and
        unusual values cost more in proportion. Else they would be bent to the utmost to stand in for an effect that is
        not yet known, or drift along what the data hardly tell for the sake of errors that nothing here can mend.
        """
        left, price = self.residuals(members, self.fitted), self.price_of(self.fitted)
        shape = (len(self.fitted), -1, len(self.channels.names))
        costs = np.asarray(np.sum(left**2, axis=(1, 2), dtype=np.float64))
        return [
            price * max(1.0, float(c)) * correlation_rows(r.reshape(shape)) for c, r in zip(costs, left, strict=True)
        ]

    def samples(self, windows: np.ndarray) -> np.ndarray:
        """Number of samples (windows,) that are compared."""
        return np.isfinite(self._compared(windows)).sum(axis=(1, 2))

    @cached_property
    def fitted(self) -> np.ndarray:
        """Indices of the windows that are fitted: those of training recordings; of very many, evenly spread ones."""
        return self.trained[:: -(-len(self.trained) // self.most)]

    @property
    def trained(self) -> np.ndarray:
        """Indices of the windows of training recordings."""
        return self.windows_of([i for i, r in enumerate(self.recordings) if r.role == "train"])

    def _doubt(self, member: Member, simulated: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """`doubt` of all windows about one member, whose readings in fitted windows are known."""
        windows = self.fitted
        starts = other_starts(self.replayer.robot.model, self.segments)
        if not starts:
            return None
        every = [s for segments in starts for s in segments]
        which = np.concatenate([windows + k * len(self.segments) for k in range(len(starts))])
        found = self._replayed([member], which, every)[0].reshape(len(starts), len(windows), *simulated.shape[1:])
        others = np.moveaxis(found, 0, -1)
        change = (others - simulated[..., None]) / self._deviation(windows)[:, None, :, None]
        sampled = np.isfinite(self._compared(windows))[..., None]
        effect = np.where(sampled, np.clip(np.nan_to_num(change), -_FAR, _FAR), 0.0)
        basis, kept = directions(effect.reshape(len(windows), -1, len(starts)))
        return self._spread(basis), 1.0 + self._spread(kept - 1.0)

    @property
    def _whole(self) -> float:
        """What makes the difference between coarse and fine steps that to no steps at all (Richardson)."""
        if int(self.replayer.robot.model.opt.integrator) == int(mujoco.mjtIntegrator.mjINT_RK4):
            return 1.0
        steps, finer = self.segments[0].steps.n_steps, self.fine[0].steps.n_steps
        return finer / max(finer - steps, 1)

    def heard(self, member: Member) -> Problem:
        """The same comparison with noise as loud as one member's residuals are from row to row.

        Differences of a reading see little of noise that lasts for some rows. Residuals hold no motion, so there it
        can be told from a mismatch, which lasts as long as motions do.
        """
        windows = self.trained
        difference = self.simulated([member], windows)[0] - self._compared(windows)
        noise = self.noise.copy()
        for recording in {self.segments[w].recording for w in windows}:
            own = np.array([self.segments[w].recording == recording for w in windows])
            noise[recording] = np.fmax(noise[recording], loudness(difference[own]))
        return replace(self, noise=noise)

    def simulated(self, members: Sequence[Member], windows: np.ndarray) -> np.ndarray:
        """Readings (members, windows, rows, channels) without the error of the step, NaN beyond a window's end."""
        found = self._replayed(members, windows, self.segments)
        for i, (hypothesis, _) in enumerate(members):
            step = self.own.get(hypothesis, self.step)
            if step is not None and self.lacking:
                found[i] += self.lacking * step[windows, : found.shape[2]]
        return found

    def exact(self) -> Problem:
        """The same comparison at the fine step, without correction: slow, and right for every member."""
        return replace(self, segments=self.fine, step=None, own={}, doubt=None)

    def _replayed(self, members: Sequence[Member], windows: np.ndarray, segments: Sequence[Segment]) -> np.ndarray:
        found = []
        step = max(1, _MOST_LANES // len(windows))
        for begin in range(0, len(members), step):
            part = members[begin : begin + step]
            early = [self._early(segments[w]) for w in windows]
            values = lanes(self.replayer.robot, self.replayer.catalogue, part, early)
            replay = self.replayer.replay(values, segments, np.tile(windows, len(part)))
            found.append(self.channels.simulated(replay).reshape(len(part), len(windows), -1, len(self.channels.names)))
        self.counted[0] += len(members) * sum(segments[w].steps.n_steps for w in windows)
        return np.concatenate(found)

    def _early(self, s: Segment) -> bool:
        """Whether a window lies before what is claimed begins; of one that holds the onset, its middle counts."""
        return 0.5 * (s.steps.start[0] + s.steps.start[-1]) < self.began.get(s.recording, -np.inf)

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

    def _compared(self, windows: np.ndarray) -> np.ndarray:
        """`recorded` without the first row of each recording: its forces belong to a command that nobody logged."""
        found = self.recorded(windows)
        found[[self.segments[w].first == 0 for w in windows], 0] = np.nan
        return found

    def residuals(self, members: Sequence[Member], windows: np.ndarray) -> np.ndarray:
        """Differences (members, windows, samples) in deviations: their squares sum to 1 where only noise is left.

        Samples are rows by channels; 0 where there is none. What other start states would explain counts little, once
        `about` has found what they do; nor does what `slack` explains count. A simulation that blew up counts as off by
        ten times the channel's range.
        """
        recorded, deviation = self._compared(windows), self._deviation(windows)[:, None, :]
        difference = (self.simulated(members, windows) - recorded) / deviation
        sampled = np.isfinite(recorded)
        limit = _BLOWN_UP * self._span(windows)[:, None, :] / deviation
        bounded = np.clip(np.nan_to_num(difference, nan=np.inf, posinf=np.inf), -limit, limit)
        flat = np.where(sampled, bounded, 0.0).astype(np.float32).reshape(len(members), len(windows), -1)
        if self.doubt is not None:
            basis, kept = self.doubt
            flat = whitened(flat, self._cut(basis, recorded.shape)[windows], kept[windows])
        flat /= np.float32(np.sqrt(sampled.sum()))
        return flat if self.slack is None else self.slack.taken_out(flat)

    def error(self, member: Member, windows: np.ndarray) -> float:
        """The nrmse of one hypothesis on windows."""
        return self.error_of(self.simulated([member], windows)[0], windows)

    def error_of(self, simulated: np.ndarray, windows: np.ndarray) -> float:
        """The nrmse of any readings (windows, rows, channels) on windows; infinite if one of them is no number."""
        shares = self._shares(simulated, windows)
        if not np.isfinite(shares[np.isfinite(self.recorded(windows))]).all():
            return float("inf")
        owner = np.array([self.segments[w].recording for w in windows])
        return nrmse([shares[owner == r].reshape(-1, shares.shape[2]) for r in np.unique(owner)])

    def shares(self, member: Member, windows: np.ndarray) -> np.ndarray:
        """Squared errors over squared ranges (windows, rows, channels) of one hypothesis, NaN without a sample."""
        return self._shares(self.simulated([member], windows)[0], windows)

    def _shares(self, simulated: np.ndarray, windows: np.ndarray) -> np.ndarray:
        return ((simulated - self.recorded(windows)) / self._span(windows)[:, None, :]) ** 2

    def _span(self, windows: np.ndarray) -> np.ndarray:
        each = {r: spans(self.channels, self.recordings[r]) for r in {self.segments[w].recording for w in windows}}
        return np.nan_to_num(np.array([each[self.segments[w].recording] for w in windows]), nan=1.0)

    def _deviation(self, windows: np.ndarray) -> np.ndarray:
        return np.nan_to_num(self.noise[[self.segments[w].recording for w in windows]], nan=1.0)

    def _cut(self, basis: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
        """Directions of all windows for windows of `shape` (windows, rows, channels), perhaps fewer rows."""
        _, rows, channels = shape
        return basis.reshape(len(basis), -1, channels, basis.shape[2])[:, :rows].reshape(len(basis), -1, basis.shape[2])
