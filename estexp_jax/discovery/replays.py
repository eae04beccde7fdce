"""Windows of recordings, replayed by robots with hypotheses, at the model's step and at parts of it.

The error of the step falls in proportion to it, except for integrators of high order: two lengths tell what no steps at
all would give, and a third how far that is to be trusted.

Source: Richardson, Philosophical Transactions of the Royal Society A 210 (1911).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import final

import mujoco
import numpy as np

from estexp_jax.discovery.hypotheses import Hypothesis, lanes
from estexp_jax.estimation.channels import Channels
from estexp_jax.estimation.windows import WindowSet
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.window import Window

Member = tuple[Hypothesis, np.ndarray]
"""A hypothesis with a vector (n_free,) of its parameters."""

_MOST_LANES = 4096
"""Lanes replayed together, to bound memory."""


@final
@dataclass(frozen=True, eq=False)
class Replays:
    """What is replayed.

    Attributes:
        replayer: of the robot and the catalogue.
        channels: the readings wanted.
        cut: the windows, at the model's own step and at parts of it.
        counted: robot steps simulated so far, a list of one number.
        began: index of a recording to the time before which nothing that is claimed acts in it, s.
        standing: what the robot has under every hypothesis.
    """

    replayer: OpenLoopSimulator
    channels: Channels
    cut: WindowSet
    counted: list[int] = field(default_factory=lambda: [0])
    began: Mapping[int, float] = field(default_factory=dict)
    standing: tuple[Change, ...] = ()

    def readings(self, members: Sequence[Member], windows: np.ndarray, segments: Sequence[Window]) -> np.ndarray:
        """Readings (members, windows, rows, channels) in some of these segments, NaN beyond a window's end."""
        found = []
        step = max(1, _MOST_LANES // len(windows))
        for begin in range(0, len(members), step):
            part = members[begin : begin + step]
            early = [self._early(segments[w]) for w in windows]
            values = lanes(self.replayer.robot, self.replayer.catalogue, part, early, self.standing)
            replay = self.replayer.replay(values, segments, np.tile(windows, len(part)))
            found.append(self.channels.simulated(replay).reshape(len(part), len(windows), -1, len(self.channels.names)))
        self.counted[0] += len(members) * sum(segments[w].steps.n_steps for w in windows)
        return np.concatenate(found)

    def _early(self, s: Window) -> bool:
        """Whether a window lies before what is claimed begins; of one that holds the onset, its middle counts."""
        return 0.5 * (s.steps.start[0] + s.steps.start[-1]) < self.began.get(s.recording, -np.inf)

    def steps(self, members: Sequence[Member], windows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Readings (members, windows, rows, channels), and what no steps at all would change in them."""
        fine, coarse = (self.readings(members, windows, segments) for segments in (self.cut.fine, self.cut.whole))
        return coarse, self._limit(coarse, fine, self.cut.parts)

    def step_about(self, member: Member, windows: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Of one member: readings, what no steps at all would change in them, and how far that is in doubt.

        All are (windows, rows, channels). Half the step makes half the error, where motion is smooth; where a foot
        touches down, it need not.
        """
        [coarse], [change] = self.steps([member], windows)
        [half] = self.readings([member], windows, self.cut.half)
        return coarse, change, np.abs(change - self._limit(coarse, half, 2))

    def _limit(self, coarse: np.ndarray, fine: np.ndarray, parts: int) -> np.ndarray:
        """What no steps at all would change, where steps cut into `parts` change this much (Richardson)."""
        high_order = int(self.replayer.robot.model.opt.integrator) == int(mujoco.mjtIntegrator.mjINT_RK4)
        return np.nan_to_num(fine - coarse) * (1.0 if high_order else parts / (parts - 1))
