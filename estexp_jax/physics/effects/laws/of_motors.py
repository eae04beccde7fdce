"""A motor that gives less than its model says, the more so the harder or the faster it works."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics import scales
from estexp_jax.physics.effects.base import Arrays, JointForce, JointMoment, Parameter, Term
from estexp_jax.physics.effects.laws.base import Shapeless, amplitude, torque
from estexp_jax.physics.effects.sites import actuator_sites
from estexp_jax.physics.robot import Robot


class _MotorLaw(Shapeless):
    """At a joint without a motor it does nothing."""

    symbols: ClassVar[str] = "m the motor's torque"


@final
class LawSoftMotor(_MotorLaw):
    """tau = -(1 - 1 / sqrt(1 + c m^2)) m of motor torque m: a limit that is reached gradually, at c^(-1/2)."""

    name: ClassVar[str] = "law_soft_motor"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("c", "1/(N m)2", signed=False),)
    equation: ClassVar[str] = "tau = -(1 - 1 / sqrt(1 + c m^2)) m, m the motor's torque"
    resembles: ClassVar[str] = "a motor that gives way gradually, the more is asked of it"

    def most(self, robot: Robot, joint: int) -> float:
        return 400.0 / torque(robot, joint) ** 2

    def formula(self, values: Mapping[str, float]) -> str:
        return f"- (1 - 1/sqrt(1 + {values['c']:.3g} m^2)) m"

    def act(self, p: Arrays, moment: JointMoment, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(motor=1.0 / jnp.sqrt(1.0 + p[0] * jnp.square(moment.torque))), state


@final
class LawSlowMotor(_MotorLaw):
    """tau = -min(a |w|, 1) m of motor torque m: a motor that gives less, the faster it turns."""

    name: ClassVar[str] = "law_slow_motor"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("a", "s/rad", signed=False),)
    equation: ClassVar[str] = "tau = -min(a |w|, 1) m, m the motor's torque"
    resembles: ClassVar[str] = "a motor that gives less, the faster it turns"

    def most(self, robot: Robot, joint: int) -> float:
        return 1.0

    def formula(self, values: Mapping[str, float]) -> str:
        return f"- min({values['a']:.3g} |w|, 1) m"

    def act(self, p: Arrays, moment: JointMoment, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(motor=jnp.maximum(1.0 - p[0] * jnp.abs(moment.w), 0.0)), state


@final
class LawSag(Term):
    """force = max(1 - a |m|, 0) m of motor torque m: a supply whose voltage falls with the current that is drawn."""

    name: ClassVar[str] = "law_sag"
    kind: ClassVar[str] = "actuator"
    named: ClassVar[bool] = False
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

    def numbered(self, values: Mapping[str, float]) -> str:
        return f"force = max(1 - {values['a']:.3g} |m|, 0) m, m the motor's nominal torque"

    def act(self, p: Arrays, moment: JointMoment, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(motor=jnp.maximum(1.0 - p[0] * jnp.abs(moment.torque), 0.0)), state
