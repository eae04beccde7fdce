"""Recordings of which one is a copy of another, in whole or in part: nothing is proved by a test that was fitted."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.checks.faults import Fault

_FEWEST, _SHARE = 20, 0.2
"""Rows in motion that have to be alike, and the share of the shorter recording's: noise alone never repeats a row."""


def copied_recordings(recordings: Sequence[Recording]) -> Iterator[tuple[int, Fault]]:
    """For each recording that repeats rows of an earlier one its index, and the fault.

    Args:
        recordings: of one robot.
    """
    marks = [_marks(recording) for recording in recordings]
    for later, recording in enumerate(recordings):
        for earlier in range(later):
            shorter, longer = sorted((marks[earlier], marks[later]), key=len)
            same = int(np.isin(shorter, longer).sum())
            if same < max(_FEWEST, _SHARE * len(shorter)):
                continue
            other = recordings[earlier]
            remedy = "it would count twice: leave one of them out"
            if "test" in (recording.role, other.role) and recording.role != other.role:
                remedy = "what was fitted proves nothing: give a test recording of its own"
            what = f"{same} rows in motion are those of {other.name}, to the last digit"
            yield later, Fault("copied_recording", "rows", f"{what}; {remedy}")


def _marks(recording: Recording) -> np.ndarray:
    """A number for each row in motion; equal rows have equal ones."""
    readings = np.hstack([recording.sensor, recording.qpos, recording.qvel])
    table = np.nan_to_num(np.hstack([recording.ctrl, readings]))
    moving = np.append(False, np.any(np.diff(np.nan_to_num(readings), axis=0) != 0.0, axis=1))
    weights = np.random.default_rng(0).normal(size=table.shape[1])
    return np.unique((table[moving] * weights).sum(axis=1))
