"""Test a first mapping: does the nominal model predict the log far better with columns exchanged, or a sign turned?

Short pieces of the log are replayed as they are mapped, and with each plausible other mapping. What physics is missing
makes all of them worse alike.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from itertools import combinations
from typing import NamedTuple

import mujoco
import numpy as np

from estexp_jax.estimation.log_replay import log_replay_of
from estexp_jax.physics.model.actuators import actuator_of_input, position_input
from estexp_jax.physics.model.log_channels import LogChannel
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_FAR_BETTER, _NOT_EXACT = 0.5, 0.02
"""Another mapping must halve the error, and the error must be above this share of the joints' ranges."""
_DEGREE, _TURN = math.pi / 180.0, 2.0 * math.pi
"""What moves less than a turn is no angle in degrees: a smaller command would stand in for friction."""


class _Mapped(NamedTuple):
    """A log under another mapping, and in what that differs."""

    recording: Recording
    difference: str


def better_mappings(robot: Robot, recording: Recording) -> list[str]:
    """What of a mapping the nominal model contradicts, as sentences; none where it cannot be tested.

    Args:
        robot: with hinge and slide joints only, all of them measured by a position sensor or `qpos`.
        recording: as it was mapped.
    """
    replay = log_replay_of(robot, recording)
    if replay is None:
        return []
    positions = [c for c in robot.channels.values() if (c.table, c.column) in replay.columns]
    commands = [c for c in robot.channels.values() if c.table == "ctrl"]
    in_degrees = {c for c in (*positions, *commands) if _is_wide(recording, c) and _is_angle(robot, c)}
    error, found = float(replay.errors([recording])[0]), list[str]()
    for _ in range(len(positions)):
        others = [*_others(recording, positions, in_degrees), *_others(recording, commands, in_degrees)]
        others += _turned(recording, positions, commands)
        errors = replay.errors([other.recording for other in others])
        least, other = float(errors.min()), others[int(errors.argmin())]
        if not (least < _FAR_BETTER * error and error > _NOT_EXACT):
            break
        better = f"the nominal model predicts the log {error / least:.2g} times better"
        found.append(f"{better} {other.difference}: check this")
        recording, error = other.recording, least
    return found


def _is_wide(recording: Recording, channel: LogChannel) -> bool:
    values = getattr(recording, channel.table)[:, channel.column]
    return bool(np.nanmax(values) - np.nanmin(values) > _TURN)


def _is_angle(robot: Robot, channel: LogChannel) -> bool:
    """Whether a channel is the position of a hinge, or the target of a hinge's position servo."""
    hinge = channel.joint is not None and robot.model.jnt_type[channel.joint] == mujoco.mjtJoint.mjJNT_HINGE
    if channel.table != "ctrl" or not hinge:
        return bool(hinge)
    return position_input(robot.model, int(actuator_of_input(robot.model)[channel.column])) == channel.column


def _others(now: Recording, channels: Sequence[LogChannel], in_degrees: Collection[LogChannel]) -> Iterator[_Mapped]:
    """The mappings that differ from one by an exchange of two columns, a sign, or a unit of those that may have it."""
    for one, other in combinations(channels, 2):
        if one.table == other.table:
            order = {one.column: other.column, other.column: one.column}
            columns = [order.get(k, k) for k in range(getattr(now, one.table).shape[1])]
            exchanged = replace(now, **{one.table: getattr(now, one.table)[:, columns]})
            yield _Mapped(exchanged, f"with {one.ours} and {other.ours} exchanged")
    for channel in channels:
        yield _Mapped(_scaled(now, channel, -1.0), f"with scale = -1.0 for {channel.ours}")
        if channel in in_degrees:
            yield _Mapped(_scaled(now, channel, _DEGREE), f'with unit = "deg" for {channel.ours}')


def _turned(now: Recording, positions: Sequence[LogChannel], commands: Sequence[LogChannel]) -> Iterator[_Mapped]:
    """The mappings in which a joint turns the other way, in its reading and its command alike."""
    for reading in positions:
        for command in commands:
            if command.joint == reading.joint:
                turned = _scaled(_scaled(now, reading, -1.0), command, -1.0)
                yield _Mapped(turned, f"with scale = -1.0 for {reading.ours} and {command.ours}")


def _scaled(recording: Recording, channel: LogChannel, factor: float) -> Recording:
    table = np.array(getattr(recording, channel.table))
    table[:, channel.column] *= factor
    return replace(recording, **{channel.table: table})
