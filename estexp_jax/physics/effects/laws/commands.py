"""A motor that loses a share of its commanded torque, or lags behind it."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.catalogue.actuator_lag import ActuatorLag
from estexp_jax.physics.effects.catalogue.dead_band import DeadBand
from estexp_jax.physics.effects.laws.base import (
    Bounds,
    JointTrajectory,
    MotionRange,
    amplitude,
    first_order_lag,
    signed_text,
)
from estexp_jax.physics.effects.laws.from_effect import EffectLaw
from estexp_jax.physics.effects.laws.motor_base import LaggedMotorLaw, MotorThresholdLaw
from estexp_jax.physics.model.robot import Robot

_LAGS = (0.001, 1.0)
"""Bounds of the time constant of a lag, s."""


@final
class LawDeafMotor(MotorThresholdLaw, EffectLaw, effect=DeadBand):
    """tau = -a min(m_0 / |s|, 1) s of the commanded torque s: a share of the first m_0 is lost.

    Of a position servo, s is the torque of the remaining position error; its damping is not affected.
    """

    name: ClassVar[str] = "law_deaf_motor"
    equation: ClassVar[str] = "tau = -a min(m_0 / |s|, 1) s, s the torque that the command asks for"
    symbols: ClassVar[str] = "s the torque that the motor's command asks for from where the joint is"
    resembles: ClassVar[str] = "a motor that does not answer to small demands"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["a"], f"min({values['m_0']:.3g}/|s|, 1) s")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The effect changes the whole command of one actuator; here a share of the joint's commanded torque is lost.
        _, asked = joint.asked()
        return JointForce(command=-p[0] * jnp.clip(asked, -p[1], p[1])), state


@final
class LawLateCommand(LaggedMotorLaw, EffectLaw, effect=ActuatorLag):
    """tau = -a (c - y) of the commanded torque c, dy/dt = (c - y) / T: a share of the command lags.

    A servo's feedback does not lag. With a = 2 the term is close to a delay of 2 T (Pade). Hidden variables are y, and
    whether a step has been taken: the first command counts as one that has been in force for long.
    """

    name: ClassVar[str] = "law_late_command"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("a", "", signed=False),
        Parameter("T", "s", neutral=0.05),
    )
    symbols: ClassVar[str] = "c the torque that the motor's command asks for wherever the joint is"
    equation: ClassVar[str] = "tau = -a (c - y), dy/dt = (c - y) / T, c the torque that the command asks for"
    resembles: ClassVar[str] = "a motor that obeys its commands late"
    n_states: ClassVar[int] = 2

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return 2.0

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (_LAGS,)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(T,) for T in self.time_constants(*_LAGS)] if motion.motor_torque > 0.0 else []

    def formula(self, values: Mapping[str, float]) -> str:
        return f"- {values['a']:.3g} (c - y) with dy/dt = (c - y)/{values['T']:.3g}"

    def hidden_along(self, p: tuple[float, ...], trajectory: JointTrajectory) -> tuple[np.ndarray, ...]:
        time, command = trajectory.time, trajectory.commanded_torque
        stepped = np.arange(len(time)) > 0
        return stepped * (command[0] + first_order_lag(command - command[0], time, p[1])), 1.0 * stepped

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The effect delays the whole command of one actuator; here a share of the joint's commanded torque lags.
        ((a, T), (lagged, stepped)), (command, _) = (p, state), joint.asked()
        lagged = jnp.where(stepped > 0.0, lagged, command)
        after = command + (lagged - command) * jnp.exp(-joint.dt / T)
        return JointForce(command=-a * (command - 0.5 * (lagged + after))), (after, jnp.ones_like(stepped))
