"""Rows that a logger lost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estexp_jax.physics.recording import Recording

_MOST = 3
"""Longer gaps are left as they are: nobody knows what was commanded meanwhile."""
_REGULAR = 0.3
"""Largest deviation from whole periods, in periods."""


def with_missing_rows(recording: Recording) -> Recording:
    """The recording with the rows that are missing from its clock put back, without readings.

    A robot was commanded at every tick; a log that lost a row holds the command before it one tick too long, and that
    tick is felt: a servo's torque jumps. The command half-way between its neighbours is nearer.
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
    """A bridged recording with other commands in the rows that were lost.

    Args:
        recording: with `guessed` rows.
        side: (rows,) for lost rows: -1 goes on as the two rows before them, 1 leads to the two rows after them, 0
            leaves what is there.
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
    """How far off a command (nu,) half-way between its neighbours is, root mean square over the logged rows."""
    ctrl = recording.ctrl if recording.guessed is None else recording.ctrl[~recording.guessed]
    if len(ctrl) < 3:
        return np.zeros(ctrl.shape[1])
    off = ctrl[1:-1] - 0.5 * (ctrl[:-2] + ctrl[2:])
    return np.sqrt(np.mean(off**2, axis=0))
