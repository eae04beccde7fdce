"""Split recordings into those that are fitted and those that are held out for the test."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.recording import HEALTHY, Recording

KEPT_BACK = 0.3
"""Share of a single recording's duration that is held out as the test."""


def without_healthy(recordings: Sequence[Recording]) -> tuple[tuple[Recording, ...], tuple[Recording, ...]]:
    """Recordings of the robot as it is, with their roles, and those of it when it was well, with roles of their own.

    Each of the two is fitted and tested for itself, by the rules of `assign_roles`; the second may be empty.

    Raises:
        InputError: as `assign_roles` does; or all recordings are of the healthy robot.
    """
    _check_stems(recordings)
    healthy = [replace(recording, role="train") for recording in recordings if recording.role == HEALTHY]
    others = [recording for recording in recordings if recording.role != HEALTHY]
    if healthy and not others:
        names = ", ".join(recording.name for recording in healthy)
        right = "recordings of the robot as it is now, with role = train or test"
        raise InputError(f"every recording is of the healthy robot: {names}", where="roles", right=right)
    return assign_roles(others), assign_roles(healthy) if healthy else ()


def assign_roles(recordings: Sequence[Recording]) -> tuple[Recording, ...]:
    """Make sure that there is at least one training and one test recording.

    Given roles are kept. Without a test recording, the last one becomes the test. A single recording is cut in two:
    its last 30 % of time is the test, named `<stem>_last30<extension>`.

    Returns:
        The recordings in the order given, at least one `train` and one `test`.

    Raises:
        InputError: there are no recordings, or only test recordings; two file names are equal up to the extension, so
            that their predictions would share a file; or a single recording is too short to cut.
    """
    if not recordings:
        raise InputError("no recordings", right="give at least one log of the robot")
    _check_stems(recordings)
    roles = [recording.role for recording in recordings]
    if "train" not in roles:
        names = ", ".join(recording.name for recording in recordings)
        right = "at least one recording to fit (role = train)"
        raise InputError(f"every recording is kept for the test: {names}", where="roles", right=right)
    if "test" in roles:
        return tuple(recordings)
    if len(recordings) == 1:
        return _cut(recordings[0])
    return (*recordings[:-1], replace(recordings[-1], role="test"))


def _check_stems(recordings: Sequence[Recording]) -> None:
    stems: dict[str, str] = {}
    for recording in recordings:
        stem = Path(recording.name).stem
        if stem in stems:
            where = f"{stems[stem]}, {recording.name}"
            right = "file names that differ before the extension, as each names its predictions"
            raise InputError(f"two recordings are called '{stem}'", where=where, right=right)
        stems[stem] = recording.name


def _cut(recording: Recording) -> tuple[Recording, Recording]:
    end = recording.time[0] + (1.0 - KEPT_BACK) * recording.duration
    rows = int(np.searchsorted(recording.time, end, side="right"))
    if rows < 2 or recording.rows - rows < 2:
        what = f"{recording.rows} rows are too few to keep the last {KEPT_BACK:.0%} back"
        raise InputError(what, where=recording.name, right="record longer, or give a second recording")
    path = Path(recording.name)
    note = f"its last {KEPT_BACK:.0%} is kept back as a test recording"
    train = replace(_slice(recording, slice(None, rows)), notes=(*recording.notes, note))
    test = _slice(recording, slice(rows, None))
    return train, replace(test, name=f"{path.stem}_last{KEPT_BACK * 100:.0f}{path.suffix}", role="test")


def _slice(recording: Recording, rows: slice) -> Recording:
    arrays = {name: getattr(recording, name)[rows] for name in ("time", "ctrl", "enable", "sensor", "qpos", "qvel")}
    return replace(recording, **arrays)
