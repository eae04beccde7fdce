"""A motor that gives less torque than its model says, depending on its torque, its speed or its heat."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.catalogue.motor_fade import MotorFade
from estexp_jax.physics.effects.catalogue.motor_weakness import MotorWeakness
from estexp_jax.physics.effects.catalogue.torque_saturation import TorqueSaturation
from estexp_jax.physics.effects.laws.base import (
    AmplitudeOnly,
    Bounds,
    JointTrajectory,
    MotionRange,
    amplitude,
    first_order_lag,
    largest_torque,
    signed_text,
)
from estexp_jax.physics.effects.laws.from_effect import EffectLaw
from estexp_jax.physics.effects.laws.motor_base import MOTOR_TORQUE, LaggedMotorLaw, MotorThresholdLaw
from estexp_jax.physics.effects.sites import actuator_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_WARMING = (0.1, 100.0)
"""Bounds of the time constant of a warming motor, s."""
_SMALL = 1e-6
"""A negligible torque, N m or N: keeps divisors from zero."""


class _MotorLaw(AmplitudeOnly):
    """A term of the motor's torque without shape parameters."""

    symbols: ClassVar[str] = MOTOR_TORQUE


@final
class LawSoftMotor(_MotorLaw):
    """tau = -(1 - 1 / sqrt(1 + c m^2)) m of motor torque m: a gradual limit at about c^(-1/2)."""

    name: ClassVar[str] = "law_soft_motor"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("c", "1/(N m)2", signed=False),)
    equation: ClassVar[str] = "tau = -(1 - 1 / sqrt(1 + c m^2)) m, m the motor's torque"
    resembles: ClassVar[str] = "a motor that gives way gradually, the more is asked of it"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return 400.0 / largest_torque(robot, joint) ** 2

    def formula(self, values: Mapping[str, float]) -> str:
        return f"- (1 - 1/sqrt(1 + {values['c']:.3g} m^2)) m"

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(motor=1.0 / jnp.sqrt(1.0 + p[0] * jnp.square(joint.torque))), state


@final
class LawSlowMotor(_MotorLaw):
    """tau = -min(a |w|, 1) m of motor torque m: the faster the motor turns, the less it gives."""

    name: ClassVar[str] = "law_slow_motor"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("a", "s/rad", signed=False),)
    equation: ClassVar[str] = "tau = -min(a |w|, 1) m, m the motor's torque"
    resembles: ClassVar[str] = "a motor that gives less, the faster it turns"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return 1.0

    def formula(self, values: Mapping[str, float]) -> str:
        return f"- min({values['a']:.3g} |w|, 1) m"

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(motor=jnp.maximum(1.0 - p[0] * jnp.abs(joint.w), 0.0)), state


@final
class LawWeakMotor(_MotorLaw, EffectLaw, effect=MotorWeakness):
    """tau = -a m of motor torque m."""

    name: ClassVar[str] = "law_weak_motor"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("a", ""),)
    equation: ClassVar[str] = "tau = -a m, m the motor's torque"
    resembles: ClassVar[str] = "a motor that gives another share of its torque"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return 1.0

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["a"], "m")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The effect edits one actuator of the model; here all motors of the joint lose a share, of either sign.
        return JointForce(motor=1.0 - p[0]), state


@final
class LawClippedMotor(MotorThresholdLaw, EffectLaw, effect=TorqueSaturation):
    """tau = -a max(1 - m_0 / |m|, 0) m of motor torque m: a share of the torque beyond m_0 is lost."""

    name: ClassVar[str] = "law_clipped_motor"
    equation: ClassVar[str] = "tau = -a max(1 - m_0 / |m|, 0) m, m the motor's torque"
    resembles: ClassVar[str] = "a motor that gives no more beyond some torque"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["a"], f"max(1 - {values['m_0']:.3g}/|m|, 0) m")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The effect is a force range in the model; here only a share of the torque beyond the limit is lost.
        beyond = jnp.maximum(1.0 - p[1] / jnp.maximum(jnp.abs(joint.torque), _SMALL), 0.0)
        return JointForce(motor=1.0 - p[0] * beyond), state


@final
class LawWarmMotor(LaggedMotorLaw, EffectLaw, effect=MotorFade):
    """tau = -a min(H / H_0, 1) m of motor torque m, dH/dt = (m^2 - H) / T: a motor that loses a share as it warms."""

    name: ClassVar[str] = "law_warm_motor"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("a", "", signed=False),
        Parameter("H_0", "(N m)2", neutral=1.0),
        Parameter("T", "s", neutral=1.0),
    )
    equation: ClassVar[str] = "tau = -a min(H / H_0, 1) m, dH/dt = (m^2 - H) / T, m the motor's torque"
    resembles: ClassVar[str] = "a motor that loses strength as it warms"

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (1e-5 * largest_torque(robot, joint) ** 2, largest_torque(robot, joint) ** 2), _WARMING

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        power = (0.3 * motion.motor_torque) ** 2  # about the mean square
        warming = self.time_constants(*_WARMING) if power > 0.0 else []
        return [(share * power, T) for share in (0.1, 0.5, 2.0) for T in warming]

    def formula(self, values: Mapping[str, float]) -> str:
        share = f"{values['a']:.3g} min(H/{values['H_0']:.3g}, 1)"
        return f"- {share} m with dH/dt = (m^2 - H)/{values['T']:.3g}"

    def hidden_along(self, p: tuple[float, ...], trajectory: JointTrajectory) -> tuple[np.ndarray, ...]:
        return (first_order_lag(trajectory.motor_torque**2, trajectory.time, p[2]),)

    def saturated_at(self, p: tuple[float, ...], largest: tuple[float, ...]) -> tuple[float, ...]:
        (a, level, T), [hottest] = p, largest
        share = min(max(hottest, _SMALL**2) / level, 1.0)
        return a * share, level * share, T

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The effect's heat counts the torque as a share of its limit; here it is in (N m)2, and the loss has an end.
        (a, level, T), (heat,) = p, state
        power = jnp.square(joint.torque)
        after = power + (heat - power) * jnp.exp(-joint.dt / T)
        return JointForce(motor=1.0 - a * jnp.minimum(heat / level, 1.0)), (after,)


@final
class LawSag(Term):
    """force = max(1 - a |m|, 0) m of motor torque m: a supply whose voltage falls with the current that is drawn."""

    name: ClassVar[str] = "law_sag"
    kind: ClassVar[str] = "actuator"
    named: ClassVar[bool] = False
    tried_beside: ClassVar[str] = "motor_fade"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("a", "1/(N m)"),)
    equation: ClassVar[str] = "force = max(1 - a |m|, 0) m, m the motor's nominal torque"
    source: ClassVar[str] = "a source with internal resistance: Horowitz and Hill, The Art of Electronics, section 1.2"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return actuator_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 20.0 / scales.motor_limit(robot, robot.index("actuator", site))),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return (
            f"the motor {site} gives less, the more is asked of it, as if its supply sagged, and as no effect of the "
            f"catalogue does: by {100 * values['a']:.3g} % at 1 N m"
        )

    def equation_with_values(self, values: Mapping[str, float]) -> str:
        return f"force = max(1 - {values['a']:.3g} |m|, 0) m, m the motor's nominal torque"

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(motor=jnp.maximum(1.0 - p[0] * jnp.abs(joint.torque), 0.0)), state
