"""Forces that depend on what another joint does."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.laws.base import Bounds, JointLaw, Reach, amplitude, half_span, signed, torque
from estexp_jax.physics.model.robot import Robot

_WITH = Parameter("with", "1 + joint index", refers="joint")


_OTHER = "in brackets the joint whose q or w it is"


class _Coupling(JointLaw):
    """With another joint, without other shapes."""

    symbols: ClassVar[str] = _OTHER

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return ((1.0, float(robot.model.njnt)),)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(1.0 + j,) for j in reach.others]


def _other(values: Mapping[str, float]) -> str:
    return f"[joint {round(values['with'])}]"


@final
class LawTow(_Coupling):
    """tau = g w' of the other joint's speed w'."""

    name: ClassVar[str] = "law_tow"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s/rad"), _WITH)
    equation: ClassVar[str] = "tau = g (speed of joint `with`)"
    resembles: ClassVar[str] = "a joint that another one drags along"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["g"], f"w{_other(values)}")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * moment.motion_of(p[1])[1]), state


@final
class LawFling(_Coupling):
    """tau = g |w'| w' of the other joint's speed w'."""

    name: ClassVar[str] = "law_fling"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), _WITH)
    equation: ClassVar[str] = "tau = g |w'| w', w' the speed of joint `with`"
    resembles: ClassVar[str] = "a joint that another one stirs up"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        w = f"w{_other(values)}"
        return signed(values["g"], f"|{w}| {w}")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        w = moment.motion_of(p[1])[1]
        return JointForce(force=p[0] * jnp.abs(w) * w), state


@final
class LawSquareFling(_Coupling):
    """tau = g w'^2 of the other joint's speed w'."""

    name: ClassVar[str] = "law_square_fling"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), _WITH)
    equation: ClassVar[str] = "tau = g w'^2, w' the speed of joint `with`"
    resembles: ClassVar[str] = "a joint that another one flings outwards"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["g"], f"w{_other(values)}^2")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * jnp.square(moment.motion_of(p[1])[1])), state


@final
class LawDriven(_Coupling):
    """tau = g m' of the other joint's motor torque m'."""

    name: ClassVar[str] = "law_driven"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", ""), _WITH)
    equation: ClassVar[str] = "tau = g m', m' the motor torque of joint `with`"
    resembles: ClassVar[str] = "a joint that another one's motor pulls at"
    stands_for: ClassVar[str] = "crosstalk"
    symbols: ClassVar[str] = "m the torque of the motor of the joint in brackets"

    def most(self, robot: Robot, joint: int) -> float:
        return 1.0

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["g"], f"m{_other(values)}")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * moment.torque_of(p[1])), state


@final
class LawStir(_Coupling):
    """tau = -g |w'| w: a damping in proportion to the other joint's speed w'."""

    name: ClassVar[str] = "law_stir"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), _WITH)
    equation: ClassVar[str] = "tau = -g |w'| w, w' the speed of joint `with`"
    resembles: ClassVar[str] = "damping that another joint's speed makes"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["g"], f"|w{_other(values)}| w")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(damping=p[0] * jnp.abs(moment.motion_of(p[1])[1])), state


@final
class LawWhirl(_Coupling):
    """tau = g w' w: like the forces of Coriolis."""

    name: ClassVar[str] = "law_whirl"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), _WITH)
    equation: ClassVar[str] = "tau = g w' w, w' the speed of joint `with`"
    resembles: ClassVar[str] = "a force of two joints' speeds"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["g"], f"w{_other(values)} w")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * moment.motion_of(p[1])[1] * moment.w), state


@final
class LawTie(JointLaw):
    """tau = -k (q' - q0) of the other joint's position q'."""

    name: ClassVar[str] = "law_tie"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("k", "N m/rad"),
        _WITH,
        Parameter("q0", "rad", signed=True),
    )
    equation: ClassVar[str] = "tau = -k (q' - q0), q' the position of joint `with`"
    resembles: ClassVar[str] = "a spring to another joint"
    symbols: ClassVar[str] = _OTHER

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint) / (0.1 * half_span(robot, joint))

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (1.0, float(robot.model.njnt)), (-2.0 * np.pi, 2.0 * np.pi)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(1.0 + j, q) for j in reach.others for q in (-0.7, 0.0, 0.7)]

    def formula(self, values: Mapping[str, float]) -> str:
        q0 = values["q0"]
        return signed(-values["k"], f"(q{_other(values)} {'-' if q0 >= 0.0 else '+'} {abs(q0):.3g})")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=-p[0] * (moment.motion_of(p[1])[0] - p[2])), state
