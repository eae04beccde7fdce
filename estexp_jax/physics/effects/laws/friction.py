"""Dry friction whose level changes with place or direction, as a friction loss renewed at each step."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.bristles import bristle_friction
from estexp_jax.physics.effects.catalogue.hysteresis import Hysteresis
from estexp_jax.physics.effects.laws.base import (
    PHASES,
    ROUND,
    WAVES,
    Bounds,
    Course,
    JointLaw,
    Reach,
    amplitude,
    away,
    half_span,
    signed,
    torque,
)
from estexp_jax.physics.effects.laws.from_effect import EffectLaw
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_TURNING = 0.01
"""Speed within which a direction is none, rad/s or m/s."""


@final
class LawTwoWayFriction(JointLaw):
    """tau = -T (1 + a sign(w)) sign(w): dry friction with another level each way."""

    name: ClassVar[str] = "law_two_way_friction"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("T", "N m", signed=False),
        Parameter("a", "", signed=True),
    )
    equation: ClassVar[str] = "tau = -T (1 + a sign(w)) sign(w)"
    resembles: ClassVar[str] = "dry friction that is larger one way than the other"
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return ((-1.0, 1.0),)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(a,) for a in (-0.9, -0.5, 0.5, 0.9)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["T"], f"(1 {signed(values['a'], 'sign(w)')}) sign(w)")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(friction=p[0] * (1.0 + p[1] * jnp.tanh(moment.w / _TURNING))), state


@final
class LawFrictionWave(JointLaw):
    """tau = -T (1 + a sin(n q + phase)) sign(w): friction that rises and falls along the way, as of a bent shaft."""

    name: ClassVar[str] = "law_friction_wave"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("T", "N m", signed=False),
        Parameter("a", ""),
        Parameter("n", "1/rad", neutral=1.0),
        Parameter("phase", "rad", signed=True),
    )
    equation: ClassVar[str] = "tau = -T (1 + a sin(n q + phase)) sign(w)"
    resembles: ClassVar[str] = "dry friction that rises and falls along the way"
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (0.0, 1.0), (0.2, 40.0 * max(np.pi / half_span(robot, joint), 1.0)), ROUND

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        scale = max(1.0, 1.5 / reach.span)
        return [(0.8, n * scale, phase) for n in WAVES for phase in PHASES]

    def formula(self, values: Mapping[str, float]) -> str:
        wave = signed(values["a"], f"sin({values['n']:.3g} q {signed(values['phase'], '')})")
        return signed(-values["T"], f"(1 {wave}) sign(w)")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        T, a, n, phase = p
        return JointForce(friction=T * (1.0 + a * jnp.sin(n * moment.q + phase))), state


@final
class LawBristles(EffectLaw, effect=Hysteresis):
    """dF/dq = (T sign(w) - F) / x, tau = -F: dry friction that builds up over a way x, like bristles that bend.

    Source: Dahl, A solid friction model, Aerospace Corporation TOR-0158 (1968).
    """

    name: ClassVar[str] = "law_bristles"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("T", "N m", signed=False),
        Parameter("x", "rad", neutral=0.1),
    )
    equation: ClassVar[str] = "tau = -F, dF/dq = (T sign(w) - F) / x"
    resembles: ClassVar[str] = "dry friction that builds up over a short way"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        half = half_span(robot, joint)
        return ((0.001 * half, half),)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(share * reach.span,) for share in (0.005, 0.02, 0.06, 0.2)]

    def formula(self, values: Mapping[str, float]) -> str:
        return f"- F with dF/dq = ({values['T']:.3g} sign(w) - F)/{values['x']:.3g}"

    def remembered(self, p: tuple[float, ...], course: Course) -> tuple[np.ndarray, ...]:
        T, x = p
        moved, force = np.diff(course.q), np.zeros(len(course.q))
        ends, left = T * np.sign(moved), np.exp(-np.abs(moved) / x)
        for i, (end, share) in enumerate(zip(ends.tolist(), left.tolist(), strict=True)):
            force[i + 1] = end + (force[i] - end) * share
        return force, course.q

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The effect takes the stiffness T / x, and dividing by it would round x: only the friction itself is shared.
        return bristle_friction(p[0], p[1], moment, state)


@final
class LawTightSpot(JointLaw):
    """tau = -T exp(-((q - q0) / s)^2) sign(w): dry friction at one place."""

    name: ClassVar[str] = "law_tight_spot"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("T", "N m", signed=False),
        Parameter("q0", "rad", signed=True),
        Parameter("s", "rad", neutral=0.1),
    )
    equation: ClassVar[str] = "tau = -T exp(-((q - q0) / s)^2) sign(w)"
    resembles: ClassVar[str] = "dry friction at one position"
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        half = half_span(robot, joint)
        return scales.joint_span(robot, joint), (0.005 * half, half)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(q, share * reach.span) for q in reach.places(9) for share in (0.06, 0.15, 0.4)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["T"], f"exp(-({away('q', values['q0'])}/{values['s']:.3g})^2) sign(w)")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(friction=p[0] * jnp.exp(-jnp.square((moment.q - p[1]) / p[2]))), state
