"""Forces that depend on how fast a joint turns, as a damping renewed at each step, so that they never overshoot."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.catalogue.stribeck_friction import StribeckFriction
from estexp_jax.physics.effects.laws.base import (
    Bounds,
    JointLaw,
    Reach,
    Shapeless,
    amplitude,
    away,
    half_span,
    signed,
    torque,
)
from estexp_jax.physics.effects.laws.from_effect import EffectLaw
from estexp_jax.physics.effects.passive import add_damper
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_SPEEDS = (0.01, 30.0)
"""Speeds at which a law may turn, rad/s or m/s."""
_STILL = 1e-3
"""A speed that is next to none: keeps tanh(x) / x a number."""


@final
class LawOneWayDamping(Shapeless):
    """tau = -c |w|: with damping, another one each way."""

    name: ClassVar[str] = "law_one_way_damping"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("c", "N m s/rad"),)
    equation: ClassVar[str] = "tau = -c |w|"
    resembles: ClassVar[str] = "damping that is larger one way than the other"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["c"], "|w|")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=-p[0] * jnp.abs(moment.w)), state


@final
class LawCubicDrag(Shapeless):
    """tau = -c w^3, of either sign."""

    name: ClassVar[str] = "law_cubic_drag"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("c", "N m s3/rad3"),)
    equation: ClassVar[str] = "tau = -c w^3"
    in_mjcf: ClassVar[bool] = True
    resembles: ClassVar[str] = "a resistance that grows steeply with speed"

    def most(self, robot: Robot, joint: int) -> float:
        return 0.3 * torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["c"], "w^3")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(damping=p[0] * jnp.square(moment.w)), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_damper(robot, spec, site, (0.0, 0.0, values["c"]))


@final
class LawSmoothFriction(JointLaw):
    """tau = -T tanh(w / w_s)."""

    name: ClassVar[str] = "law_smooth_friction"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("T", "N m"), Parameter("w_s", "rad/s", neutral=1.0))
    equation: ClassVar[str] = "tau = -T tanh(w / w_s)"
    resembles: ClassVar[str] = "friction that sets in gradually with speed"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (_SPEEDS,)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(share * reach.speed,) for share in (0.01, 0.03, 0.1, 0.3, 0.6)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["T"], f"tanh(w/{values['w_s']:.3g})")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        x = jnp.maximum(jnp.abs(moment.w) / p[1], _STILL)
        return JointForce(damping=p[0] / p[1] * jnp.tanh(x) / x), state


@final
class LawFallingFriction(EffectLaw, effect=StribeckFriction):
    """tau = -T sign(w) / (1 + (w / w_s)^2): dry friction that falls off once the joint moves.

    Source: Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994), section 2.3, after Hess and Soom.
    """

    name: ClassVar[str] = "law_falling_friction"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("T", "N m", signed=False),
        Parameter("w_s", "rad/s", neutral=1.0),
    )
    equation: ClassVar[str] = "tau = -T sign(w) / (1 + (w / w_s)^2)"
    resembles: ClassVar[str] = "dry friction that falls off with speed"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (_SPEEDS,)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(share * reach.speed,) for share in (0.03, 0.1, 0.25, 0.5)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["T"], f"sign(w) / (1 + (w/{values['w_s']:.3g})^2)")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # Another curve than the effect's exponential, with no level beneath it.
        return JointForce(friction=p[0] / (1.0 + jnp.square(moment.w / p[1]))), state


@final
class LawHump(JointLaw):
    """tau = -2 T x / (1 + x^2), x = w / w_s: a resistance that is largest at one speed, as of eddy currents.

    Source: Smythe, Transactions of the AIEE 61 (1942).
    """

    name: ClassVar[str] = "law_hump"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("T", "N m"), Parameter("w_s", "rad/s", neutral=1.0))
    equation: ClassVar[str] = "tau = -2 T x / (1 + x^2), x = w / w_s"
    resembles: ClassVar[str] = "a resistance that is largest at one speed"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (_SPEEDS,)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(share * reach.speed,) for share in (0.03, 0.1, 0.25, 0.5, 0.8)]

    def formula(self, values: Mapping[str, float]) -> str:
        x = f"(w/{values['w_s']:.3g})"
        return signed(-2.0 * values["T"], f"{x} / (1 + {x}^2)")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(damping=2.0 * p[0] / p[1] / (1.0 + jnp.square(moment.w / p[1]))), state


@final
class LawPlaceDamping(JointLaw):
    """tau = -c (q - q0)^2 w: a damping that grows away from some position."""

    name: ClassVar[str] = "law_place_damping"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("c", "N m s/rad3"), Parameter("q0", "rad", signed=True))
    equation: ClassVar[str] = "tau = -c (q - q0)^2 w"
    resembles: ClassVar[str] = "damping that changes along the way"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint) / (0.1 * half_span(robot, joint)) ** 2

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (scales.joint_span(robot, joint),)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(q,) for q in (reach.low, *reach.places(9), reach.high)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["c"], f"{away('q', values['q0'])}^2 w")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(damping=p[0] * jnp.square(moment.q - p[1])), state
