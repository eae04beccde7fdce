"""What is withheld from the program, and known because it was put there.

Only the command and sensor sides, and what the program is given as known, can be changed faithfully in a log: a command
that is logged early is a robot that obeys late; a load that is given too light is a mass it must find. Where only
positions are read, masses and motors scaled alike move alike: a value given wrong must be further off than others,
refitted within their 30 %, could make up for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from experiments.explain.machines.devices import Columns

Change = Callable[[Columns, np.ndarray], Columns]
"""A log changed, given its time in s."""


class Truth(NamedTuple):
    """An effect at an element, with one parameter and its value."""

    effect: str
    kind: str
    element: str
    parameter: str
    value: float


@dataclass(frozen=True)
class Withheld:
    """Something known that is kept from the program.

    Attributes:
        name: of the case.
        device, split: whose logs.
        truth: what is there to be found; None: nothing is missing that was not missing before.
        change: what is done to each log.
        model: what is replaced in the MJCF.
        factor: of the settings that are given.
        same: another truth that says the same of these logs.
    """

    name: str
    device: str
    split: str
    truth: Truth | None
    change: Change | None = None
    model: tuple[str, str] | None = None
    factor: float = 1.0
    same: Truth | None = None


@final
@dataclass(frozen=True)
class Shifted:
    """A column that shows what was so many seconds before (negative: after)."""

    column: str
    seconds: float

    def __call__(self, log: Columns, time: np.ndarray) -> Columns:
        """The changed log."""
        return log | {self.column: np.interp(time - self.seconds, time, log[self.column])}


@final
@dataclass(frozen=True)
class Scaled:
    """A column times a factor plus an offset."""

    column: str
    factor: float
    offset: float = 0.0

    def __call__(self, log: Columns, time: np.ndarray) -> Columns:
        """The changed log."""
        return log | {self.column: self.factor * log[self.column] + self.offset}


@final
@dataclass(frozen=True)
class Quantised:
    """A column rounded to steps."""

    column: str
    step: float

    def __call__(self, log: Columns, time: np.ndarray) -> Columns:
        """The changed log."""
        return log | {self.column: np.round(log[self.column] / self.step) * self.step}


_XL330, _PENDULUM, _SO101 = ("xl330", "kp800"), ("double_pendulum", "swing_up"), ("so101", "held_out")
WITHHELD = (
    Withheld(
        "xl330-late-command",
        *_XL330,
        Truth("command_delay", "actuator", "servo", "delay", 0.06),
        Shifted("goal_position", -0.06),
        same=Truth("sensor_delay", "sensor", "angle", "delay", 0.06),  # the servo's own loop is not logged
    ),
    Withheld(
        "xl330-biased-sensor",
        *_XL330,
        Truth("sensor_bias", "sensor", "angle", "bias", 0.15),
        Scaled("position", 1.0, 0.15),
    ),
    Withheld(
        "xl330-wrong-scale", *_XL330, Truth("sensor_gain", "sensor", "angle", "gain", 1.25), Scaled("position", 1.25)
    ),
    Withheld(
        "xl330-light-load",
        *_XL330,
        Truth("body_mass", "body", "arm", "dm", 0.34),
        model=('mass="0.49"', 'mass="0.15"'),
        same=Truth("motor_weakness", "actuator", "servo", "loss", 1.0 - 0.15 / 0.49),
    ),
    Withheld("xl330-stiff-servo", *_XL330, Truth("motor_weakness", "actuator", "servo", "loss", 0.75), factor=4.0),
    Withheld("xl330-coarse-encoder", *_XL330, None, Quantised("position", 0.0123)),
    Withheld(
        "pendulum-light-link",
        *_PENDULUM,
        Truth("body_mass", "body", "link2", "dm", 0.31279),
        model=(
            'mass="0.62557" diaginertia="0.009970 0.009970 0.0005"',
            'mass="0.31278" diaginertia="0.004985 0.004985 0.00025"',
        ),
    ),
    Withheld(
        "pendulum-weak-motor",
        *_PENDULUM,
        Truth("motor_weakness", "actuator", "elbow", "loss", 0.7),
        Scaled("tau_meas2", 1.0 / 0.3),
    ),
    Withheld(
        "pendulum-biased-sensor",
        *_PENDULUM,
        Truth("sensor_bias", "sensor", "q2", "bias", 0.1),
        Scaled("pos_meas2", 1.0, 0.1),
        same=Truth("joint_offset", "joint", "elbow", "offset", 0.1),  # torques drive the last joint: both act alike
    ),
    Withheld(
        "pendulum-late-command",
        *_PENDULUM,
        Truth("command_delay", "actuator", "elbow", "delay", 0.04),
        Shifted("tau_meas2", -0.04),
    ),
    Withheld(
        "so101-late-command",
        *_SO101,
        Truth("command_delay", "actuator", "Elbow", "delay", 0.06),
        Shifted("command_Elbow", -0.06),
    ),
    Withheld(
        "so101-biased-sensor",
        *_SO101,
        Truth("sensor_bias", "sensor", "Wrist_Roll_pos", "bias", 0.15),
        Scaled("position_Wrist_Roll", 1.0, 0.15),
    ),
    Withheld(
        "so101-wrong-scale",
        *_SO101,
        Truth("sensor_gain", "sensor", "Pitch_pos", "gain", 1.2),
        Scaled("position_Pitch", 1.2),
    ),
)
"""All withheld truths; scored against the same logs without them."""
