"""One case: what is concealed in which robot, its recordings, and its answer."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import mujoco

from experiments.benchmark.generator.effect import Effect
from experiments.benchmark.generator.motors import Motors
from experiments.benchmark.generator.plant import Trace
from experiments.benchmark.generator.sensing import Instruments
from experiments.benchmark.generator.visibility import Visibility

TEST = (0.9,)
"""Amplitudes of the test recordings, as shares of the full one."""


@dataclass(frozen=True)
class Planted:
    """An effect at a place.

    Attributes:
        effect: key of the catalogue.
        joint: index of the joint it is at, or whose motor, sensor or body; -1: everywhere.
        strength: 0.03 barely visible to 0.7 plain.
    """

    effect: str
    joint: int
    strength: float


@dataclass(frozen=True)
class Plan:
    """What a case is to be.

    Attributes:
        group: null, parameters, single, relative, unknown, pair, masked, onset, hidden, absorbed.
        robot: its name.
        planted: what is concealed.
        seed: of everything random in it.
        by_hand: whether the equations written by hand move it.
        plain: parameters are off by 1 %, encoders have 14 bits, noise has no memory, no row is lost.
        tests: amplitudes of the test recordings, as shares of the full one.
    """

    group: str
    robot: str
    planted: tuple[Planted, ...]
    seed: int
    by_hand: bool = False
    plain: bool = False
    tests: tuple[float, ...] = TEST


@dataclass(frozen=True)
class Recorded:
    """A recording before its sensors have spoilt it."""

    name: str
    rows: Trace
    whole: Trace
    onset: float | None = None

    @property
    def steps(self) -> Trace:
        """What happened at the nominal steps since the first row; `whole` begins somewhat earlier."""
        return self.whole.logged()


@dataclass(frozen=True)
class Case:
    """A case with its truth.

    Attributes:
        plan: what it was to be.
        nominal: the MJCF that is given.
        recorded: its recordings.
        effects: made, with their parameters, beside `plan.planted`.
        instruments: how good the sensors are.
        visible: how visible the difference is.
        twin: and how visible it were without the effects, with the same wrong values, where bodies touch: their motions
            part by themselves.
        truth, motors: the true model without its effects, and its motors.
        wrong: relative errors of the parameters that were made wrong on purpose.
        deviation: of the ordinary parameter errors.
        shorter: its recordings have this share of their usual length.
    """

    plan: Plan
    nominal: str
    recorded: tuple[Recorded, ...]
    effects: tuple[Effect, ...]
    instruments: Instruments
    visible: Visibility
    truth: mujoco.MjModel
    motors: Motors
    wrong: dict[str, float] = field(default_factory=dict)
    deviation: float = 0.0
    shorter: float = 1.0
    twin: Visibility | None = None


def stronger(plan: Plan, factor: float) -> Plan:
    """The same with other strengths."""
    return replace(plan, planted=tuple(replace(p, strength=min(0.9, p.strength * factor)) for p in plan.planted))
