"""A motor that does less than its command asks for, or does it late."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.catalogue.actuator_lag import ActuatorLag
from estexp_jax.physics.effects.catalogue.dead_band import DeadBand
from estexp_jax.physics.effects.laws.base import Bounds, Course, Reach, amplitude, followed, signed
from estexp_jax.physics.effects.laws.from_effect import EffectLaw
from estexp_jax.physics.effects.laws.motor_base import Remembering, Threshold
from estexp_jax.physics.model.robot import Robot

_LATE = (0.001, 1.0)
"""Time constants of what comes late, s."""


@final
class LawDeafMotor(Threshold, EffectLaw, effect=DeadBand):
    """tau = -a min(m_0 / |s|, 1) s of what the command asks for, s: a share of the first m_0 is lost.

    Of a position servo, s is the torque of the way left to go; its damping acts as ever.
    """

    name: ClassVar[str] = "law_deaf_motor"
    equation: ClassVar[str] = "tau = -a min(m_0 / |s|, 1) s, s the torque that the command asks for"
    symbols: ClassVar[str] = "s the torque that the motor's command asks for from where the joint is"
    resembles: ClassVar[str] = "a motor that does not answer to small demands"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["a"], f"min({values['m_0']:.3g}/|s|, 1) s")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The effect changes the whole command of one actuator; here a share of the joint's commanded torque is lost.
        _, asked = moment.asked()
        return JointForce(command=-p[0] * jnp.clip(asked, -p[1], p[1])), state


@final
class LawLateCommand(Remembering, EffectLaw, effect=ActuatorLag):
    """tau = -a (c - y) of what the command asks for in all, c, dy/dt = (c - y) / T: of a command a share comes late.

    What a servo makes of where the joint is does not come late. With a = 2 it is close to a delay of 2 T (Pade).
    The first command has been in force for long: hidden are y, and whether there has been any.
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

    def most(self, robot: Robot, joint: int) -> float:
        return 2.0

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (_LATE,)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(T,) for T in self.constants(*_LATE)] if reach.motor > 0.0 else []

    def formula(self, values: Mapping[str, float]) -> str:
        return f"- {values['a']:.3g} (c - y) with dy/dt = (c - y)/{values['T']:.3g}"

    def remembered(self, p: tuple[float, ...], course: Course) -> tuple[np.ndarray, ...]:
        begun = np.arange(len(course.time)) > 0
        return begun * (course.told[0] + followed(course.told - course.told[0], course.time, p[1])), 1.0 * begun

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The effect delays the whole command of one actuator; here a share of the joint's commanded torque lags.
        ((a, T), (late, begun)), (told, _) = (p, state), moment.asked()
        late = jnp.where(begun > 0.0, late, told)
        after = told + (late - told) * jnp.exp(-moment.dt / T)
        return JointForce(command=-a * (told - 0.5 * (late + after))), (after, jnp.ones_like(begun))
