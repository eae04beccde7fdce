"""No signal: a column holds something else than what its sensor reads."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import ClassVar, final

import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Parameter
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.logging_fault import LoggingFault
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.model.log_channels import LogChannel
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_FEWEST = 50
"""Samples from which a reading is judged."""
_LAGS, _MOST_ALIKE = 25, 0.3
"""A motion is like itself some rows later; noise is so less than this at all lags: four deviations at the fewest."""
_SAME = 2e-3
"""Root mean square of the difference, as a share of the spread, up to which two columns are copies."""
_MOVED = {int(mujoco.mjtJoint.mjJNT_HINGE): 0.02, int(mujoco.mjtJoint.mjJNT_SLIDE): 0.001}
"""A joint whose reading spreads by less than this, rad or m, may be at rest."""
_LARGEST = 10.0
"""Largest deviation of noise, in the sensor's unit."""


@register_effect
@final
class NoSignal(LoggingFault):
    """The reading is noise of deviation `std`, or a copy of another reading or command (1 + its index)."""

    name: ClassVar[str] = "no_signal"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("std", "sensor unit"),
        Parameter("copy_of", "1 + channel index", refers="channel"),
    )
    equation: ClassVar[str] = "reading = noise, or another channel"
    source: ClassVar[str] = "an input that is not connected, or a column that was written twice"
    masks_readings: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return tuple(name for name, channel in robot.channels.items() if channel.measures_position)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return (0.0, _LARGEST), (0.0, float(len(robot.channels)))

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        copied = int(values["copy_of"])
        what = f"a copy of channel number {copied}" if copied else f"noise of {values['std']:.3g}"
        return f"the reading {site} does not follow the robot: it is {what}"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(1.0, 0.0)]

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return ("See that each sensor is connected and its column the right one, then record again.",)

    def plain(self, robot: Robot, site: str, recording: Recording) -> Mapping[str, float] | None:
        own = robot.channels[site]
        values = _column(recording, own)
        samples = values[np.isfinite(values)]
        if len(samples) < _FEWEST or not np.std(samples) > _MOVED[int(robot.model.jnt_type[own.joint or 0])]:
            return None
        if is_noise(samples):
            return {"std": float(np.std(samples)), "copy_of": 0.0}
        for k, other in enumerate(robot.channels.values()):
            if other != own and _is_copy(robot, recording, own, other):
                return {"std": 0.0, "copy_of": 1.0 + k}
        return None

    def logged(self, robot: Robot, recording: Recording, site: str, values: Mapping[str, float]) -> Recording:
        own, copied = robot.channels[site], int(values["copy_of"])
        if copied:
            logged = _column(recording, list(robot.channels.values())[min(copied, len(robot.channels)) - 1])
        elif not values["std"] > 0.0:
            return recording
        else:
            logged = np.random.default_rng(recording.rows).normal(0.0, values["std"], recording.rows)
        return _with(recording, own, logged)

    def mended(self, robot: Robot, recording: Recording, site: str, values: Mapping[str, float]) -> Recording:
        return _with(recording, robot.channels[site], np.full(recording.rows, np.nan))


def is_noise(samples: np.ndarray) -> bool:
    """Whether samples (n,) tell nothing of those that follow."""
    x = samples - samples.mean()
    size = float(x @ x)
    alike = [float(x[:-lag] @ x[lag:]) / size for lag in range(1, min(_LAGS, len(x) // 2) + 1)]
    return max(abs(each) for each in alike) < _MOST_ALIKE


def _is_copy(robot: Robot, recording: Recording, own: LogChannel, other: LogChannel) -> bool:
    """Whether a reading repeats another channel, and is the one that does not belong to its joint."""
    reading, copied = _column(recording, own), _column(recording, other)
    if other.quantity == own.quantity:
        same = _difference(reading, copied) < _SAME
        return same and _obeys(robot, recording, own) <= _obeys(robot, recording, other)
    if other.table != "ctrl" or other.joint is None:
        return False
    return min(_difference(reading, copied), _difference(reading[1:], copied[:-1])) < _SAME


def _difference(one: np.ndarray, other: np.ndarray) -> float:
    """Root mean square of the difference of two columns, over the spread of the first; infinite where none is known."""
    both = np.isfinite(one) & np.isfinite(other)
    if both.sum() < _FEWEST or not np.std(one[both]) > 0.0:
        return float("inf")
    return float(np.sqrt(np.mean(np.square(one[both] - other[both]))) / np.std(one[both]))


def _obeys(robot: Robot, recording: Recording, own: LogChannel) -> float:
    """How much of a reading's motion goes along with the commands of its joint, 0 to 1."""
    reading = _column(recording, own)
    rows = np.isfinite(reading)
    found = [0.0]
    for channel in robot.channels.values():
        command = _column(recording, channel)[rows] if channel.table == "ctrl" and channel.joint == own.joint else None
        if command is not None and np.std(command) > 0.0:
            found.append(abs(float(np.corrcoef(reading[rows], command)[0, 1])))
    return max(found)


def _column(recording: Recording, channel: LogChannel) -> np.ndarray:
    return getattr(recording, channel.table)[:, channel.column]


def _with(recording: Recording, channel: LogChannel, values: np.ndarray) -> Recording:
    table = np.array(getattr(recording, channel.table))
    table[:, channel.column] = values
    return replace(recording, **{channel.table: table})
