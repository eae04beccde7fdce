"""Terms of unknown laws: each is a force on a joint as a function of its motion, with free coefficients.

An unknown law is the sum of a few terms at one joint. The first parameter of each term is its amplitude: at zero there
is no force, and to first order the force is proportional to it.

Source: Brunton, Proctor and Kutz, PNAS 113 (2016): sparse regression over a library of candidate terms.
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

UNKNOWN_LAW = "unknown_law"
"""The name under which all of them are reported."""
Bounds = tuple[tuple[float, float], ...]
"""Lowest and highest value of each of some parameters."""


class MotionRange(NamedTuple):
    """Range of a joint's motion in recordings: initial values of shape parameters depend on it."""

    low: float  #: position, rad or m
    high: float
    speed: float  #: that few samples exceed
    duration: float  #: of a recording, s
    motor_torque: float = 0.0  #: of its motors, that few samples exceed, N m or N
    other_joints: tuple[int, ...] = ()  #: indices of the other joints that moved

    def positions(self, n: int) -> list[float]:
        """Positions inside the range, evenly spread."""
        return np.linspace(self.low, self.high, n + 2)[1:-1].tolist()

    @property
    def span(self) -> float:
        """Length of the range, rad or m."""
        return max(self.high - self.low, 1e-6)


class JointTrajectory(NamedTuple):
    """A joint's motion and motor torque in one recording, (samples,) each."""

    time: np.ndarray  #: since the recording began, s
    q: np.ndarray  #: position, rad or m
    w: np.ndarray  #: speed
    motor_torque: np.ndarray  #: of its motors, N m or N
    commanded_torque: np.ndarray  #: what their commands ask for in all, N m or N


class JointLaw(Term):
    """A term of an unknown law at a joint.

    Its parameters after the amplitude are its shape parameters.

    Class attributes:
        resembles: what it is like, in words.
        symbols: what its formula's letters mean, beside q, w and tau.
        stands_for: a named effect that says the same: the term does not count where that effect may be claimed.
    """

    kind: ClassVar[str] = "joint"
    named: ClassVar[bool] = False
    source: ClassVar[str] = "Brunton, Proctor and Kutz, PNAS 113 (2016)"
    resembles: ClassVar[str]
    symbols: ClassVar[str] = ""
    stands_for: ClassVar[str] = ""

    @abc.abstractmethod
    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        """Bound of the amplitude, in its unit."""

    @abc.abstractmethod
    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        """Bounds (low, high) of each shape parameter."""

    @abc.abstractmethod
    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        """Initial guesses of the shape parameters: one value of each in every guess."""

    @abc.abstractmethod
    def formula(self, values: Mapping[str, float]) -> str:
        """Its force with numbers, beginning with + or -."""

    def hidden_along(self, p: tuple[float, ...], trajectory: JointTrajectory) -> tuple[np.ndarray, ...]:
        """The hidden variables (samples,) along a recording, in closed form; `n_states` of them."""
        return ()

    def saturated_at(self, p: tuple[float, ...], largest: tuple[float, ...]) -> tuple[float, ...]:
        """Parameters of a term that does not extrapolate in its hidden variables.

        Args:
            p: the parameters.
            largest: largest absolute value of each hidden variable in the recordings. Up to there the force stays the
                same; beyond, it is the smallest that the law's form allows.
        """
        return p

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> Bounds:
        joint = robot.index("joint", site)
        largest = self.largest_amplitude(robot, joint)
        return (-largest if self.parameters[0].signed else 0.0, largest), *self.shape_bounds(robot, joint)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the joint {site} feels a force of {self.formula(values)}"


class AmplitudeOnly(JointLaw):
    """A term without shape parameters."""

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return ()

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [()]


def amplitude(name: str, unit: str, *, signed: bool = True) -> Parameter:
    """The first parameter of a term."""
    return Parameter(name, unit, signed=signed)


def largest_torque(robot: Robot, joint: int) -> float:
    """Largest torque of a term, N m or N."""
    return 0.8 * scales.joint_torque(robot, joint)


def first_order_lag(cause: np.ndarray, time: np.ndarray, constant: float) -> np.ndarray:
    """A variable (samples,) that lags a cause with a time constant, s, from 0 on: dx/dt = (cause - x) / constant."""
    lagged, last = np.zeros(len(time)), 0.0
    for i, left in enumerate(np.exp(-np.diff(time) / constant).tolist()):
        last = cause[i] + (last - cause[i]) * left
        lagged[i + 1] = last
    return lagged


def half_span(robot: Robot, joint: int) -> float:
    """Half the range of a joint, rad or m."""
    low, high = scales.joint_span(robot, joint)
    return 0.5 * (high - low)


def signed_text(value: float, text: str) -> str:
    """`+ 0.12 text` or `- 0.12 text`."""
    return f"{'-' if value < 0.0 else '+'} {abs(value):.3g} {text}".rstrip()


def difference_text(name: str, origin: float) -> str:
    """`(q - 0.3)`, or `(q + 0.3)`."""
    return f"({name} {'-' if origin >= 0.0 else '+'} {abs(origin):.3g})"


SPATIAL_FREQUENCIES = tuple(float(n) for n in np.geomspace(0.5, 40.0, 24))
"""Initial guesses of a spatial frequency, 1/rad."""
INITIAL_PHASES = (-np.pi / 2, 0.0, np.pi / 2, np.pi)
"""Initial guesses of a phase, rad."""
PHASE_BOUNDS = (-2.0 * np.pi, 2.0 * np.pi)
"""Bounds of a phase, rad."""
