"""Terms of laws that no catalogue holds: each a force on a joint from what can be known there, with free coefficients.

Added up at one joint, a few of them make an unknown law. The amplitude is each term's first parameter; at zero there is
no force, and to first order the force is proportional to it.

Source: Brunton, Proctor and Kutz, PNAS 113 (2016): laws as the fewest terms of a library that pay.
"""

from __future__ import annotations

import abc
from collections.abc import Mapping
from typing import ClassVar, NamedTuple

import numpy as np

from estexp_jax.physics.effects.base import Parameter, Term
from estexp_jax.physics.effects.sites import scalar_joint_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

UNKNOWN = "unknown_law"
"""The name under which all of them are told."""
Bounds = tuple[tuple[float, float], ...]
"""Lowest and highest value of each of some parameters."""


class Reach(NamedTuple):
    """Where a joint went in recordings: what starts of shapes depend on."""

    low: float  #: position, rad or m
    high: float
    speed: float  #: that few samples exceed
    length: float  #: of a recording, s
    motor: float = 0.0  #: torque of its motors that few samples exceed, N m or N
    others: tuple[int, ...] = ()  #: indices of the other joints that moved

    def places(self, n: int) -> list[float]:
        """Positions inside, evenly spread."""
        return np.linspace(self.low, self.high, n + 2)[1:-1].tolist()

    @property
    def span(self) -> float:
        """Length of the range."""
        return max(self.high - self.low, 1e-6)


class Course(NamedTuple):
    """What a joint did in a recording, (samples,) each."""

    time: np.ndarray  #: since its beginning, s
    q: np.ndarray  #: position, rad or m
    w: np.ndarray  #: speed
    motor: np.ndarray  #: torque of its motors, N m or N
    told: np.ndarray  #: torque that their commands ask for in all


class JointLaw(Term):
    """A term of an unknown law at a joint.

    Class attributes:
        resembles: what it is like, in words.
        symbols: what its formula's letters mean, beside q, w and tau.
        stands_for: an effect of the catalogue that says the same: beside it the term does not count.
    """

    kind: ClassVar[str] = "joint"
    named: ClassVar[bool] = False
    source: ClassVar[str] = "Brunton, Proctor and Kutz, PNAS 113 (2016)"
    resembles: ClassVar[str]
    symbols: ClassVar[str] = ""
    stands_for: ClassVar[str] = ""

    @abc.abstractmethod
    def most(self, robot: Robot, joint: int) -> float:
        """Largest amplitude that is looked for."""

    @abc.abstractmethod
    def shapes(self, robot: Robot, joint: int) -> Bounds:
        """Bounds (low, high) of each parameter but the first."""

    @abc.abstractmethod
    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        """Values of each parameter but the first, between which a search may start."""

    @abc.abstractmethod
    def formula(self, values: Mapping[str, float]) -> str:
        """Its force with numbers, beginning with + or -."""

    def remembered(self, p: tuple[float, ...], course: Course) -> tuple[np.ndarray, ...]:
        """The hidden variables (samples,) along a recording, in closed form; as many as there are."""
        return ()

    def held(self, p: tuple[float, ...], reached: tuple[float, ...]) -> tuple[float, ...]:
        """The values with the same force while hidden variables stay below what they reached, and least beyond it."""
        return p

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> Bounds:
        joint = robot.index("joint", site)
        most = self.most(robot, joint)
        return (-most if self.parameters[0].signed else 0.0, most), *self.shapes(robot, joint)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the joint {site} feels a force of {self.formula(values)}"


class Shapeless(JointLaw):
    """A term with no parameter but its amplitude."""

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return ()

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [()]


def amplitude(name: str, unit: str, *, signed: bool = True) -> Parameter:
    """The first parameter of a term."""
    return Parameter(name, unit, signed=signed)


def torque(robot: Robot, joint: int) -> float:
    """Torque that a term may reach, N m or N."""
    return 0.8 * scales.joint_torque(robot, joint)


def followed(cause: np.ndarray, time: np.ndarray, constant: float) -> np.ndarray:
    """A variable (samples,) that follows a cause with a time constant, s, from 0 on: dx/dt = (cause - x) / constant."""
    found, last = np.zeros(len(time)), 0.0
    for i, left in enumerate(np.exp(-np.diff(time) / constant).tolist()):
        last = cause[i] + (last - cause[i]) * left
        found[i + 1] = last
    return found


def half_span(robot: Robot, joint: int) -> float:
    """Half the range of a joint, rad or m."""
    low, high = scales.joint_span(robot, joint)
    return 0.5 * (high - low)


def signed(value: float, text: str) -> str:
    """`+ 0.12 text` or `- 0.12 text`."""
    return f"{'-' if value < 0.0 else '+'} {abs(value):.3g} {text}".rstrip()


def away(name: str, place: float) -> str:
    """`(q - 0.3)`, or `(q + 0.3)`."""
    return f"({name} {'-' if place >= 0.0 else '+'} {abs(place):.3g})"


WAVES = tuple(float(n) for n in np.geomspace(0.5, 40.0, 24))
"""Spatial frequencies that are tried, 1/rad."""
PHASES = (-np.pi / 2, 0.0, np.pi / 2, np.pi)
"""Phases that are tried, rad."""
ROUND = (-2.0 * np.pi, 2.0 * np.pi)
"""Bounds of a phase, rad."""
