"""Forces that depend on the speed of a joint, as a damping renewed at each step, so that they never overshoot."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.catalogue.stribeck_friction import StribeckFriction
from estexp_jax.physics.effects.laws.base import (
    AmplitudeOnly,
    Bounds,
    JointLaw,
    MotionRange,
    amplitude,
    difference_text,
    half_span,
    largest_torque,
    signed_text,
)
from estexp_jax.physics.effects.laws.from_effect import EffectLaw
from estexp_jax.physics.effects.passive import add_damper
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_SPEEDS = (0.01, 30.0)
"""Bounds of a characteristic speed, rad/s or m/s."""
_STILL = 1e-3
"""A negligible ratio of speeds: keeps tanh(x) / x a number."""


@final
class LawOneWayDamping(AmplitudeOnly):
    """tau = -c |w|: beside damping, another damping in each direction."""

    name: ClassVar[str] = "law_one_way_damping"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("c", "N m s/rad"),)
    equation: ClassVar[str] = "tau = -c |w|"
    resembles: ClassVar[str] = "damping that is larger one way than the other"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["c"], "|w|")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=-p[0] * jnp.abs(joint.w)), state


@final
class LawCubicDrag(AmplitudeOnly):
    """tau = -c w^3, of either sign."""

    name: ClassVar[str] = "law_cubic_drag"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("c", "N m s3/rad3"),)
    equation: ClassVar[str] = "tau = -c w^3"
    in_mjcf: ClassVar[bool] = True
    resembles: ClassVar[str] = "a resistance that grows steeply with speed"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return 0.3 * largest_torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["c"], "w^3")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(damping=p[0] * jnp.square(joint.w)), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_damper(robot, spec, site, (0.0, 0.0, values["c"]))


@final
class LawSmoothFriction(JointLaw):
    """tau = -T tanh(w / w_s)."""

    name: ClassVar[str] = "law_smooth_friction"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("T", "N m"), Parameter("w_s", "rad/s", neutral=1.0))
    equation: ClassVar[str] = "tau = -T tanh(w / w_s)"
    resembles: ClassVar[str] = "friction that sets in gradually with speed"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (_SPEEDS,)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(share * motion.speed,) for share in (0.01, 0.03, 0.1, 0.3, 0.6)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["T"], f"tanh(w/{values['w_s']:.3g})")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        x = jnp.maximum(jnp.abs(joint.w) / p[1], _STILL)
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
    in_mjcf: ClassVar[bool] = False  # the effect's curve is another one
    resembles: ClassVar[str] = "dry friction that falls off with speed"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (_SPEEDS,)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(share * motion.speed,) for share in (0.03, 0.1, 0.25, 0.5)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["T"], f"sign(w) / (1 + (w/{values['w_s']:.3g})^2)")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The curve is not the effect's exponential, and the friction falls to zero.
        return JointForce(friction=p[0] / (1.0 + jnp.square(joint.w / p[1]))), state


@final
class LawHump(JointLaw):
    """tau = -2 T x / (1 + x^2), x = w / w_s: a resistance that is largest at one speed, as of eddy currents.

    Source: Smythe, Transactions of the AIEE 61 (1942).
    """

    name: ClassVar[str] = "law_hump"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("T", "N m"), Parameter("w_s", "rad/s", neutral=1.0))
    equation: ClassVar[str] = "tau = -2 T x / (1 + x^2), x = w / w_s"
    resembles: ClassVar[str] = "a resistance that is largest at one speed"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (_SPEEDS,)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(share * motion.speed,) for share in (0.03, 0.1, 0.25, 0.5, 0.8)]

    def formula(self, values: Mapping[str, float]) -> str:
        x = f"(w/{values['w_s']:.3g})"
        return signed_text(-2.0 * values["T"], f"{x} / (1 + {x}^2)")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(damping=2.0 * p[0] / p[1] / (1.0 + jnp.square(joint.w / p[1]))), state


@final
class LawPlaceDamping(JointLaw):
    """tau = -c (q - q0)^2 w: a damping that grows away from some position."""

    name: ClassVar[str] = "law_place_damping"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("c", "N m s/rad3"), Parameter("q0", "rad", signed=True))
    equation: ClassVar[str] = "tau = -c (q - q0)^2 w"
    resembles: ClassVar[str] = "damping that changes along the way"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint) / (0.1 * half_span(robot, joint)) ** 2

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (scales.joint_span(robot, joint),)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(q,) for q in (motion.low, *motion.positions(9), motion.high)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["c"], f"{difference_text('q', values['q0'])}^2 w")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(damping=p[0] * jnp.square(joint.q - p[1])), state
