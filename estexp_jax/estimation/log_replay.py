"""Short pieces of a log replayed by the nominal model, each from the state that its readings show.

What physics the model lacks makes a piece a little wrong; a wrong column or clock makes it very wrong. All pieces of
all versions of a log go through MuJoCo in one batch.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple, final

import mujoco
import mujoco.rollout
import numpy as np

from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.reading_noise import noise_std_of
from estexp_jax.physics.recording import Recording

_PIECES, _PIECE_S, _SLOPE_S = 12, 0.4, 0.02
"""Pieces of a log, their length, and the time to either side over which a speed is taken, s."""
_FORGOTTEN_S = 0.1
"""For about so long a wrong speed at the beginning grows, before the motors have overcome it, s."""
_THREADS = 2
_COMPARED = 10
"""Times in a piece at which positions are compared."""
_MOST_JOINTS, _FEWEST_SAMPLES = 16, 20
_MOST_STEPS = 400
"""Of a piece: of a model with a shorter step, pieces are shorter."""
_BATCH = 4_000_000
"""Most numbers of one batch."""
_JOINTPOS = int(mujoco.mjtSensor.mjSENS_JOINTPOS)


class Pieces(NamedTuple):
    """Pieces of one version of a log."""

    state: np.ndarray  #: (pieces, nstate) where each begins
    control: np.ndarray  #: (pieces, steps, nu)
    reached: np.ndarray  #: (pieces, times, joints) what readings say of it
    on: np.ndarray  #: (pieces,) whether all motors are on
    spans: np.ndarray  #: (pieces, joints) range of each position in the log


@final
@dataclass(frozen=True, eq=False)
class LogReplay:
    """A robot whose logs can be replayed.

    Attributes:
        model: with what is known of the recording.
        data: of the model, one a thread.
        columns: for each joint the table and the column of a recording that have its position.
        spans: (joints,) range of each position in the log as it is, rad or m.
        floor: error that noise alone makes, as `errors` gives it.
    """

    model: mujoco.MjModel
    data: tuple[mujoco.MjData, ...]
    columns: tuple[tuple[str, int], ...]
    spans: np.ndarray
    floor: float

    def errors(self, recordings: Sequence[Recording], models: Sequence[mujoco.MjModel] = ()) -> np.ndarray:
        """Root mean square error of each version of the log in all joints, as a share of their ranges, at most 1.

        Args:
            recordings: versions of the log.
            models: of each version, of the same sizes; by default its own model.
        """
        return np.sqrt(np.nanmean(np.minimum(np.square(self.residuals(recordings, models)), 1.0), axis=(1, 2, 3)))

    def residuals(self, recordings: Sequence[Recording], models: Sequence[mujoco.MjModel] = ()) -> np.ndarray:
        """Simulated less recorded (versions, pieces, times, joints), over the ranges; NaN where motors are off."""
        each = models or [self.model] * len(recordings)
        size = self._steps * (self.model.nu + mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
        count = max(_BATCH // (size * _PIECES), 1)
        parts = range(0, len(recordings), count)
        found = [self._residuals(recordings[k : k + count], each[k : k + count]) for k in parts]
        return np.concatenate(found)

    def _residuals(self, recordings: Sequence[Recording], models: Sequence[mujoco.MjModel]) -> np.ndarray:
        known = {id(r): self._pieces(r) for r in recordings}
        pieces = [known[id(r)] for r in recordings]
        state, control, reached, on, spans = (np.concatenate(arrays) for arrays in zip(*pieces, strict=True))
        every = [model for model in models for _ in range(_PIECES)]
        found = np.asarray(mujoco.rollout.rollout(every, list(self.data), state, control)[0])
        model, first = self.model, 1  # after the time
        simulated = found[:, self._compared - 1][:, :, first + model.jnt_qposadr]
        left = (simulated - reached) / spans[:, None]
        left[~np.isfinite(left)] = 1.0
        left[~on] = np.nan
        return left.reshape(len(recordings), _PIECES, len(self._compared), -1)

    @property
    def count(self) -> int:
        """How many differences an error is made of."""
        return _PIECES * len(self._compared) * len(self.columns)

    @property
    def _steps(self) -> int:
        return max(min(int(_PIECE_S / self.model.opt.timestep), _MOST_STEPS), 2)

    @property
    def _compared(self) -> np.ndarray:
        """Numbers of the steps after which positions are compared."""
        return np.unique(np.linspace(1, self._steps, _COMPARED + 1).astype(int)[1:])

    def _pieces(self, recording: Recording) -> Pieces:
        step, time = float(self.model.opt.timestep), recording.time
        half = max(_SLOPE_S, float(np.median(np.diff(time))))
        first, last = time[0] + half, time[-1] - self._steps * step - half
        begins = np.linspace(first, max(last, first), _PIECES)
        at = begins[:, None] + step * np.arange(self._steps)
        rows = np.clip(np.searchsorted(time, at + 1e-9, side="right") - 1, 0, len(time) - 1)
        later = begins[:, None] + step * self._compared
        positions = [_sampled(recording, column) for column in self.columns]
        initial = np.stack([np.interp(begins, *p) for p in positions], axis=1)
        speeds = [(np.interp(begins + half, *p) - np.interp(begins - half, *p)) / (2 * half) for p in positions]
        reached = np.stack([np.interp(later, *p) for p in positions], axis=2)
        control, data = recording.ctrl[rows], self.data[0]
        begin = zip(initial, np.stack(speeds, axis=1), control[:, 0], strict=True)
        state = np.stack([_state(self.model, data, *each) for each in begin])
        spans = np.tile([float(np.ptp(values)) for _, values in positions], (_PIECES, 1))
        return Pieces(state, control, reached, np.min(recording.enable[rows], axis=(1, 2)) > 0.0, spans)


def log_replay_of(robot: Robot, recording: Recording) -> LogReplay | None:
    """The robot, if pieces of a log can be replayed; None where a joint's position is not measured or none moves.

    Args:
        robot: with what is known of the recording.
        recording: the log.
    """
    model = robot.model
    if not model.nu or not 1 <= model.njnt <= _MOST_JOINTS or len(robot.scalar_joints) < model.njnt:
        return None
    columns: dict[int, tuple[str, int]] = {}
    for channel in robot.channels.values():
        if channel.joint is not None and channel.measures_position and channel.joint not in columns:
            samples = getattr(recording, channel.table)[:, channel.column]
            samples = samples[np.isfinite(samples)]
            if len(samples) >= _FEWEST_SAMPLES and np.ptp(samples) > 0.0:
                columns[channel.joint] = channel.table, channel.column
    if len(columns) < model.njnt or recording.duration < 4 * _PIECE_S:
        return None
    ordered = tuple(columns[joint] for joint in range(model.njnt))
    positions = [getattr(recording, table)[:, column] for table, column in ordered]
    spans = np.array([float(np.nanmax(p) - np.nanmin(p)) for p in positions])
    noise = np.array([noise_std_of(recording.time, p) for p in positions])
    half = max(_SLOPE_S, float(np.median(np.diff(recording.time))))
    lost = 1.0 + _FORGOTTEN_S / (np.sqrt(2.0) * half)  # of where a piece begins, and at which speed
    data = tuple(mujoco.MjData(model) for _ in range(_THREADS))
    replay = LogReplay(model, data, ordered, spans, float(np.sqrt(np.mean(np.square(lost * noise / spans)))))
    return replay if np.isfinite(replay.errors([recording])).all() else None


def _sampled(recording: Recording, column: tuple[str, int]) -> tuple[np.ndarray, np.ndarray]:
    """Times and values of a column's samples."""
    values = getattr(recording, column[0])[:, column[1]]
    there = np.isfinite(values)
    return recording.time[there], values[there]


def _state(model: mujoco.MjModel, data: mujoco.MjData, q: np.ndarray, w: np.ndarray, u: np.ndarray) -> np.ndarray:
    """The state with joints at q and at speeds w, where commands u have been in force for long."""
    mujoco.mj_resetData(model, data)
    data.qpos[model.jnt_qposadr], data.qvel[model.jnt_dofadr] = q, w
    filtered = (model.actuator_actadr >= 0) & (model.actuator_ctrlnum == 1)
    data.act[model.actuator_actadr[filtered]] = u[model.actuator_ctrladr[filtered]]
    state = np.empty(mujoco.mj_stateSize(model, mujoco.mjtState.mjSTATE_FULLPHYSICS))
    mujoco.mj_getState(model, data, state, mujoco.mjtState.mjSTATE_FULLPHYSICS)
    return state
