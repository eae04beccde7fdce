"""Faults of logging that the nominal model sees: columns exchanged, readings without a signal, clocks displaced."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from estexp_jax.estimation.log_faults import FoundFault, found_faults, untold_joints
from estexp_jax.physics.effects.changes import sentence_of
from estexp_jax.physics.effects.registry import logging_faults
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recordings.checks.faults import Fault


def model_faults(robot: Robot, recording: Recording, *, beside_physics: bool = True) -> Iterator[Fault]:
    """Faults of logging that a recording shows, one line each.

    Args:
        robot: with the recording's settings applied.
        recording: the log.
        beside_physics: whether such as physics may hide are looked for as well.
    """
    for found in found_faults(robot, recording, beside_physics=beside_physics)[0]:
        change = found.change
        effect = next(e for e in logging_faults() if e.name == change.effect)
        name = robot.channels[change.name].ours if change.name in robot.channels else "time"
        remedy = effect.advice([recording])[0].rstrip(".")
        yield Fault(effect.name, name, f"{sentence_of(robot, change)}{_ratio(found)}; {_small(remedy)}")


def assumed(robot: Robot, recording: Recording) -> list[str]:
    """What of the columns' assignment to joints nothing in a recording tells, as sentences."""
    return [
        f"nothing in this log tells to which of two joints {' and '.join(robot.channels[c].ours for c in channels)} "
        "belong: their columns' names are believed"
        for channels in untold_joints(robot, recording)
    ]


def _ratio(found: FoundFault) -> str:
    if np.isnan(found.before):
        return ""
    return f": the nominal model predicts the log {found.before / found.after:.2g} times better so"


def _small(sentence: str) -> str:
    return sentence[:1].lower() + sentence[1:]
