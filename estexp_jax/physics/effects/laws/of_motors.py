"""A motor that gives less than its model says, by how hard or how fast it works."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics import scales
from estexp_jax.physics.effects.base import Arrays, JointForce, JointMoment, Parameter, Term
from estexp_jax.physics.effects.laws.base import (
    Bounds,
    Course,
    JointLaw,
    Reach,
    Shapeless,
    amplitude,
    followed,
    signed,
    torque,
)
from estexp_jax.physics.effects.sites import actuator_sites
from estexp_jax.physics.robot import Robot

_MOTOR = "m the motor's torque"
"""A joint without a motor has none, so that these laws do nothing there."""
_WARMING, _LATE = (0.1, 100.0), (0.001, 1.0)
"""Time constants of a motor that warms, and of one whose torque comes late, s."""
_SMALL = 1e-6
"""A torque that is next to none, N m or N."""


class _MotorLaw(Shapeless):
    """Without other shapes."""

    symbols: ClassVar[str] = _MOTOR


class _Threshold(JointLaw):
    """A share of the motor's torque that is lost, and the torque where that begins or ends."""

    symbols: ClassVar[str] = _MOTOR
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("a", "", signed=False),
        Parameter("m_0", "N m", neutral=1.0),
    )

    def most(self, robot: Robot, joint: int) -> float:
        return 1.0

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return ((0.001 * torque(robot, joint), 2.0 * torque(robot, joint)),)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(share * reach.motor,) for share in (0.05, 0.15, 0.3, 0.5, 0.75)] if reach.motor > 0.0 else []


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
class LawWeakMotor(_MotorLaw):
    """tau = -a m of motor torque m."""

    name: ClassVar[str] = "law_weak_motor"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("a", ""),)
    equation: ClassVar[str] = "tau = -a m, m the motor's torque"
    resembles: ClassVar[str] = "a motor that gives another share of its torque"
    stands_for: ClassVar[str] = "motor_weakness"

    def most(self, robot: Robot, joint: int) -> float:
        return 1.0

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["a"], "m")

    def act(self, p: Arrays, moment: JointMoment, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(motor=1.0 - p[0]), state


@final
class LawClippedMotor(_Threshold):
    """tau = -a max(1 - m_0 / |m|, 0) m of motor torque m: of what is asked beyond m_0 a share is lost."""

    name: ClassVar[str] = "law_clipped_motor"
    equation: ClassVar[str] = "tau = -a max(1 - m_0 / |m|, 0) m, m the motor's torque"
    resembles: ClassVar[str] = "a motor that gives no more beyond some torque"
    stands_for: ClassVar[str] = "torque_saturation"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["a"], f"max(1 - {values['m_0']:.3g}/|m|, 0) m")

    def act(self, p: Arrays, moment: JointMoment, state: Arrays) -> tuple[JointForce, Arrays]:
        beyond = jnp.maximum(1.0 - p[1] / jnp.maximum(jnp.abs(moment.torque), _SMALL), 0.0)
        return JointForce(motor=1.0 - p[0] * beyond), state


@final
class LawDeafMotor(_Threshold):
    """tau = -a min(m_0 / |m|, 1) m of motor torque m: a share of the first m_0 is lost."""

    name: ClassVar[str] = "law_deaf_motor"
    equation: ClassVar[str] = "tau = -a min(m_0 / |m|, 1) m, m the motor's torque"
    resembles: ClassVar[str] = "a motor that does not answer to small demands"
    stands_for: ClassVar[str] = "dead_band"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["a"], f"min({values['m_0']:.3g}/|m|, 1) m")

    def act(self, p: Arrays, moment: JointMoment, state: Arrays) -> tuple[JointForce, Arrays]:
        within = jnp.minimum(p[1] / jnp.maximum(jnp.abs(moment.torque), _SMALL), 1.0)
        return JointForce(motor=1.0 - p[0] * within), state


class _Remembering(JointLaw):
    """A share of the motor's torque by a variable that follows it, or its square, with the time constant T."""

    symbols: ClassVar[str] = _MOTOR
    n_states: ClassVar[int] = 1

    def most(self, robot: Robot, joint: int) -> float:
        return 1.0

    @staticmethod
    def constants(low: float, high: float) -> list[float]:
        """Time constants to try, s."""
        return np.geomspace(2.0 * low, 0.3 * high, 5).tolist()


@final
class LawWarmMotor(_Remembering):
    """tau = -a H / (H + H_0) m of motor torque m, dH/dt = (m^2 - H) / T: a motor that loses a share as it warms."""

    name: ClassVar[str] = "law_warm_motor"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("a", "", signed=False),
        Parameter("H_0", "(N m)2", neutral=1.0),
        Parameter("T", "s", neutral=1.0),
    )
    equation: ClassVar[str] = "tau = -a H / (H + H_0) m, dH/dt = (m^2 - H) / T, m the motor's torque"
    resembles: ClassVar[str] = "a motor that loses strength as it warms"
    stands_for: ClassVar[str] = "motor_fade"

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (1e-5 * torque(robot, joint) ** 2, torque(robot, joint) ** 2), _WARMING

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        power = (0.3 * reach.motor) ** 2  # about the mean
        warming = self.constants(*_WARMING) if power > 0.0 else []
        return [(share * power, T) for share in (0.1, 0.5, 2.0) for T in warming]

    def formula(self, values: Mapping[str, float]) -> str:
        share = f"{values['a']:.3g} H/(H + {values['H_0']:.3g})"
        return f"- {share} m with dH/dt = (m^2 - H)/{values['T']:.3g}"

    def remembered(self, p: tuple[float, ...], course: Course) -> tuple[np.ndarray, ...]:
        return (followed(course.motor**2, course.time, p[2]),)

    def act(self, p: Arrays, moment: JointMoment, state: Arrays) -> tuple[JointForce, Arrays]:
        (a, level, T), (heat,) = p, state
        power = jnp.square(moment.torque)
        after = power + (heat - power) * jnp.exp(-moment.dt / T)
        return JointForce(motor=1.0 - a * heat / (heat + level)), (after,)


@final
class LawLazyMotor(_Remembering):
    """tau = -a (m - y) of motor torque m, dy/dt = (m - y) / T: of a motor's torque a share comes late."""

    name: ClassVar[str] = "law_lazy_motor"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("a", "", signed=False),
        Parameter("T", "s", neutral=0.05),
    )
    equation: ClassVar[str] = "tau = -a (m - y), dy/dt = (m - y) / T, m the motor's torque"
    resembles: ClassVar[str] = "a motor whose torque comes late"
    stands_for: ClassVar[str] = "actuator_lag"

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (_LATE,)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(T,) for T in self.constants(*_LATE)] if reach.motor > 0.0 else []

    def formula(self, values: Mapping[str, float]) -> str:
        return f"- {values['a']:.3g} (m - y) with dy/dt = (m - y)/{values['T']:.3g}"

    def remembered(self, p: tuple[float, ...], course: Course) -> tuple[np.ndarray, ...]:
        return (followed(course.motor, course.time, p[1]),)

    def act(self, p: Arrays, moment: JointMoment, state: Arrays) -> tuple[JointForce, Arrays]:
        (a, T), (late,) = p, state
        after = moment.torque + (late - moment.torque) * jnp.exp(-moment.dt / T)
        return JointForce(force=-a * (moment.torque - 0.5 * (late + after))), (after,)


@final
class LawLoadFriction(_MotorLaw):
    """tau = -mu |m| sign(w) of motor torque m: teeth that rub the more, the more they carry."""

    name: ClassVar[str] = "law_load_friction"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("mu", "", signed=False),)
    equation: ClassVar[str] = "tau = -mu |m| sign(w), m the motor's torque"
    resembles: ClassVar[str] = "friction in proportion to the motor's torque"
    stands_for: ClassVar[str] = "load_dependent_friction"
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)

    def most(self, robot: Robot, joint: int) -> float:
        return 0.95

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["mu"], "|m| sign(w)")

    def act(self, p: Arrays, moment: JointMoment, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(friction=p[0] * jnp.abs(moment.torque)), state


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
