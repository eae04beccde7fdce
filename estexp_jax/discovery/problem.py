"""The comparison that all hypotheses are put to: windows of recordings, replayed and subtracted."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, final

import numpy as np

from estexp_jax.discovery.hypotheses import Hypothesis, Place
from estexp_jax.discovery.recorded import Recorded, louder_noise, observed_of
from estexp_jax.discovery.replays import Member, Replays
from estexp_jax.discovery.slack import Slack
from estexp_jax.discovery.uncertain_starts import blinded, directions, other_commands, other_starts, whitened
from estexp_jax.estimation.channels import Channels
from estexp_jax.estimation.noise import correlation_rows
from estexp_jax.estimation.windows import WindowSet, is_sensitive_to_start
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import Window

_BLOWN_UP = 10.0
"""Normalised error of a simulation that is no longer a number: worse than any that stays on its scale."""
_FAR = 1e6
"""Deviations; further is a simulation that blew up."""


@final
@dataclass(frozen=True, eq=False)
class Problem:
    """Recordings cut into windows, and the simulator to replay them.

    Attributes:
        replays: of the windows, by the simulator.
        recordings: what was recorded.
        noise: (recordings, channels) deviation that counts as one, in the channel's unit; NaN where it has no sample.
        places: what may be claimed.
        step: (windows, rows, channels) what no steps at all would change, found at one member by `about`; added to
            everything simulated, because a step of some milliseconds alone may look like friction or delay.
        rough: (windows, rows, channels) how far that is in doubt, found by `about` too: where a foot touches down, half
            the step does not make half the error. It counts as noise.
        own: `step` for hypotheses at whose fits it was found by `corrected`: a coarse step distorts dry friction and
            stops otherwise than free motion.
        lacking: share of it that the robot lacks: 1 for real ones, less for one that was simulated itself.
        most: so many windows are fitted at most.
        likely: values to start the search for some claims from, where a look at the forces suggests some.
        hairs: whether motions were seen to hang on hairs: the windows in which they part then count little in fits.
        doubt: directions and factors of `doubt.directions` for each window, found by `about` too.
        slack: what values of the model and earlier claims would explain, if they were fitted; None: they are not.
        memory: the state of each stage of fitting, plain numbers and arrays by its name: kept by the caller, it lets an
            interrupted explanation go on where it was.
    """

    replays: Replays
    recordings: tuple[Recording, ...]
    memory: dict[str, Any]
    noise: np.ndarray
    places: tuple[Place, ...]
    step: np.ndarray | None = None
    rough: np.ndarray | None = None
    own: Mapping[Hypothesis, np.ndarray] = field(default_factory=dict)
    lacking: float = 1.0
    doubt: tuple[np.ndarray, np.ndarray] | None = None
    slack: Slack | None = None
    most: int = 48
    likely: Mapping[Place, Vectors] = field(default_factory=dict)
    hairs: bool = False

    @property
    def replayer(self) -> OpenLoopSimulator:
        """The simulator, of the robot and the catalogue."""
        return self.replays.replayer

    @property
    def channels(self) -> Channels:
        """The readings compared."""
        return self.replays.channels

    @property
    def parting(self) -> bool:
        """Whether motions soon part for good from those of a robot that differs a little."""
        return self.hairs or is_sensitive_to_start(self.replayer.robot)

    @property
    def counted(self) -> list[int]:
        """Robot steps simulated so far, a list of one number."""
        return self.replays.counted

    @property
    def segments(self) -> tuple[Window, ...]:
        """The windows at the model's own step."""
        return self.replays.cut.whole

    @property
    def recorded(self) -> Recorded:
        """The readings in the windows, and what counts as one deviation of them."""
        return Recorded(self.recordings, self.channels, self.segments, self.noise, self.rough)

    def with_windows(self, cut: WindowSet, began: Mapping[int, float] | None = None) -> Problem:
        """The same comparison in other windows, of whose steps and starts nothing is known yet.

        Args:
            cut: the windows.
            began: as in `Replays`.
        """
        there = replace(self.replays, cut=cut, began=began or {})
        return replace(self, replays=there, step=None, rough=None, own={}, doubt=None)

    def windows_of(self, recordings: Sequence[int]) -> np.ndarray:
        """Indices of the windows of some recordings."""
        return np.array([i for i, s in enumerate(self.segments) if s.recording in recordings], dtype=int)

    def about(self, member: Member) -> Problem:
        """The same comparison with what one member shows: the error of the coarse step, and of uncertain starts."""
        coarse, step, rough = self.replays.step_about(member, self.fitted)
        there = replace(self, step=self._spread(self._longest(step)), rough=self._spread(self._longest(rough)), own={})
        return replace(there, doubt=there._doubt(member, coarse))

    def corrected(self, members: Sequence[Member]) -> Problem:
        """The same comparison, in which each of these hypotheses is corrected by the step's error at its own fit."""
        _, steps = self.replays.steps(members, self.fitted)
        found = {h: self._spread(self._longest(step)) for (h, _), step in zip(members, steps, strict=True)}
        return replace(self, own={**self.own, **found})

    def _spread(self, x: np.ndarray) -> np.ndarray:
        """An array of fitted windows (windows, ...) among all windows, 0 for others."""
        whole = np.zeros((len(self.segments), *x.shape[1:]), x.dtype)
        whole[self.fitted] = x
        return whole

    def _longest(self, x: np.ndarray) -> np.ndarray:
        """An array (windows, rows, ...) with as many rows as the longest of all windows has, 0 in the new ones."""
        more = max(s.rows for s in self.segments) - x.shape[1]
        return np.pad(x, [(0, 0), (0, more), *[(0, 0)] * (x.ndim - 2)])

    def price_of(self, windows: np.ndarray) -> float:
        """Price of a model's value being off by an ordinary error: that of one sample a deviation off, all costing 1.

        So weighs a normal prior of that deviation against as many independent samples.
        """
        return 1.0 / max(float(self.recorded.samples(windows).sum()), 1.0)

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

    @cached_property
    def fitted(self) -> np.ndarray:
        """Indices of the windows that are fitted: those of training recordings; of very many, evenly spread ones."""
        n = min(len(self.trained), self.most)
        return self.trained[np.linspace(0, len(self.trained) - 1, n).round().astype(int)]

    @property
    def trained(self) -> np.ndarray:
        """Indices of the windows of training recordings."""
        return self.windows_of([i for i, r in enumerate(self.recordings) if r.role == "train"])

    def _doubt(self, member: Member, simulated: np.ndarray) -> tuple[np.ndarray, np.ndarray] | None:
        """`doubt` of all windows about one member, whose readings in fitted windows are known."""
        windows = self.fitted
        robot = self.replayer.robot
        known = [self.segments[w] for w in windows]
        others = [*other_starts(robot.model, blinded(robot, member[0], known)), *other_commands(self.recordings, known)]
        if not others:
            return None
        changed = [(k, i, s) for k, copies in enumerate(others) for i, s in enumerate(copies) if s is not None]
        [found] = self.replays.readings([member], np.arange(len(changed)), [s for _, _, s in changed])
        rows = found.shape[1]
        change = np.zeros((*simulated.shape, len(others)))
        for (k, i, _), readings in zip(changed, found, strict=True):
            change[i, :rows, :, k] = readings - simulated[i, :rows]
        change /= self.recorded.deviation(windows, simulated.shape[1])[..., None]
        sampled = np.isfinite(self.recorded.compared(windows))[..., None]
        effect = np.where(sampled, np.clip(np.nan_to_num(change), -_FAR, _FAR), 0.0)
        basis, kept = directions(self._longest(effect).reshape(len(windows), -1, len(others)))
        return self._spread(basis), 1.0 + self._spread(kept - 1.0)

    def heard(self, member: Member) -> Problem:
        """The same comparison with noise as loud as one member's residuals are from row to row.

        Differences of a reading see little of noise that lasts for some rows. Residuals hold no motion, so there it
        can be told from a mismatch, which lasts as long as motions do; most of them: what swings fast is no noise.
        """
        windows = self.trained
        difference = self.simulated([member], windows)[0] - self.recorded.compared(windows)
        noise = louder_noise(self.noise, [self.segments[w].recording for w in windows], difference)
        return replace(self, noise=noise)

    def simulated(self, members: Sequence[Member], windows: np.ndarray) -> np.ndarray:
        """Readings (members, windows, rows, channels) without the error of the step, NaN beyond a window's end."""
        found = self.replays.readings(members, windows, self.segments)
        for i, (hypothesis, _) in enumerate(members):
            step = self.own.get(hypothesis, self.step)
            if step is not None and self.lacking:
                found[i] += self.lacking * step[windows, : found.shape[2]]
        return found

    def exact(self) -> Problem:
        """The same comparison at the fine step, without correction: slow, and right for every member."""
        return self.with_windows(self.replays.cut.exact(), self.replays.began)

    @cached_property
    def seen(self) -> Observed:
        """Where joints were and what sensors showed in the training recordings, for where to start."""
        return observed_of(self.recordings, self.segments)

    def residuals(self, members: Sequence[Member], windows: np.ndarray) -> np.ndarray:
        """Differences (members, windows, samples) in deviations: their squares sum to 1 where only noise is left.

        Samples are rows by channels; 0 where there is none. What other start states would explain counts little, once
        `about` has found what they do; nor does what `slack` explains count. A simulation that blew up counts as off by
        ten times the channel's range.
        """
        recorded = self.recorded.compared(windows)
        deviation = self.recorded.deviation(windows, recorded.shape[1])
        difference = (self.simulated(members, windows) - recorded) / deviation
        sampled = np.isfinite(recorded)
        limit = (_BLOWN_UP * self.recorded.span(windows)[:, None, :] / deviation).astype(np.float32)
        far = np.where(np.isfinite(difference), np.clip(difference, -_FAR, _FAR), limit)
        flat = np.where(sampled, far, 0.0).astype(np.float32).reshape(len(members), len(windows), -1)
        if self.doubt is not None:
            basis, kept = self.doubt
            flat = whitened(flat, self._cut(basis, recorded.shape)[windows], kept[windows])
        most = np.broadcast_to(limit, recorded.shape).reshape(len(windows), -1)
        flat = np.clip(flat, -most, most)  # not before: what a start's error does to a joint at rest exceeds its range
        flat /= np.float32(np.sqrt(sampled.sum()))
        return flat if self.slack is None else self.slack.taken_out(flat)

    def error(self, member: Member, windows: np.ndarray) -> float:
        """The nrmse of one hypothesis on windows."""
        return self.recorded.error_of(self.simulated([member], windows)[0], windows)

    def _cut(self, basis: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
        """Directions of all windows for windows of `shape` (windows, rows, channels), perhaps fewer rows."""
        _, rows, channels = shape
        return basis.reshape(len(basis), -1, channels, basis.shape[2])[:, :rows].reshape(len(basis), -1, basis.shape[2])
