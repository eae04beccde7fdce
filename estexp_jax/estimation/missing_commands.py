"""Rows that a logger dropped: insertion, interpolated commands, and their error."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estexp_jax.physics.recording import Recording

_MOST = 3
"""Rows of the longest gap that is filled; commands in longer ones are unknown."""
_REGULAR = 0.3
"""Largest deviation of a gap from whole periods, in periods."""


def with_missing_rows(recording: Recording) -> Recording:
    """The recording with dropped rows inserted, without readings and with interpolated commands.

    The robot received a command at every tick. Without the row, the command before it would be held one tick too long,
    and a servo's torque would jump. A linear interpolation is closer to the true command.
    """
    steps = np.diff(recording.time)
    periods = steps / np.median(steps)
    whole = np.round(periods)
    lost = np.where((whole >= 2) & (whole <= 1 + _MOST) & (np.abs(periods - whole) <= _REGULAR), whole - 1, 0).astype(
        int
    )
    if not lost.any():
        return recording
    before = np.repeat(np.arange(recording.rows), np.append(lost, 0) + 1)
    rank = np.arange(len(before)) - np.searchsorted(before, before)
    share = rank / (np.append(lost, 0) + 1)[before]
    after = np.minimum(before + 1, recording.rows - 1)

    def between(table: np.ndarray) -> np.ndarray:
        weight = share.reshape(-1, *([1] * (table.ndim - 1)))
        return np.where(weight > 0.0, (1.0 - weight) * table[before] + weight * table[after], table[before])

    def known(table: np.ndarray) -> np.ndarray:
        return np.where(rank[:, None] > 0, np.nan, table[before])

    return replace(
        recording,
        time=between(recording.time),
        ctrl=between(recording.ctrl),
        enable=recording.enable[before],
        sensor=known(recording.sensor),
        qpos=known(recording.qpos),
        qvel=known(recording.qvel),
        guessed=rank > 0,
    )


def with_other_commands(recording: Recording, side: np.ndarray) -> Recording:
    """A recording with other commands in its inserted rows.

    Args:
        recording: as of `with_missing_rows`.
        side: (rows,) for inserted rows: -1 extrapolates the two rows before them, 1 the two rows after them, 0 changes
            nothing.
    """
    if recording.guessed is None or not side.any():
        return recording
    logged, ctrl = np.flatnonzero(~recording.guessed), recording.ctrl.copy()
    for row in np.flatnonzero(recording.guessed & (side != 0)):
        near = logged[logged < row][-2:][::-1] if side[row] < 0 else logged[logged > row][:2]
        if len(near):
            first, second = near[0], near[-1]
            slope = (ctrl[first] - ctrl[second]) / max(abs(first - second), 1)
            ctrl[row] = ctrl[first] + slope * abs(row - first)
    return replace(recording, ctrl=ctrl)


def interpolation_error(recording: Recording) -> np.ndarray:
    """Root mean square error (nu,) of commands interpolated between their neighbours, over the logged rows."""
    ctrl = recording.ctrl if recording.guessed is None else recording.ctrl[~recording.guessed]
    if len(ctrl) < 3:
        return np.zeros(ctrl.shape[1])
    off = ctrl[1:-1] - 0.5 * (ctrl[:-2] + ctrl[2:])
    return np.sqrt(np.mean(off**2, axis=0))
