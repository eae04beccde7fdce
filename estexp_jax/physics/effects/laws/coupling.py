"""Forces that depend on what another joint does."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.laws.base import Bounds, JointLaw, Reach, amplitude, half_span, signed, torque
from estexp_jax.physics.model.robot import Robot

OTHER_JOINT = Parameter("with", "1 + joint index", refers="joint")
"""The other joint, as a parameter."""
_SYMBOLS = "in brackets the joint whose q or w it is"


class Coupling(JointLaw):
    """A term whose only parameter beside its amplitude is the other joint."""

    symbols: ClassVar[str] = _SYMBOLS

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return ((1.0, float(robot.model.njnt)),)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(1.0 + j,) for j in reach.others]


def other_joint(values: Mapping[str, float]) -> str:
    """`[joint 2]`, as formulas name the other joint."""
    return f"[joint {round(values['with'])}]"


@final
class LawTow(Coupling):
    """tau = g w' of the other joint's speed w'."""

    name: ClassVar[str] = "law_tow"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s/rad"), OTHER_JOINT)
    equation: ClassVar[str] = "tau = g (speed of joint `with`)"
    resembles: ClassVar[str] = "a joint that another one drags along"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["g"], f"w{other_joint(values)}")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * moment.motion_of(p[1])[1]), state


@final
class LawFling(Coupling):
    """tau = g |w'| w' of the other joint's speed w'."""

    name: ClassVar[str] = "law_fling"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), OTHER_JOINT)
    equation: ClassVar[str] = "tau = g |w'| w', w' the speed of joint `with`"
    resembles: ClassVar[str] = "a joint that another one stirs up"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        w = f"w{other_joint(values)}"
        return signed(values["g"], f"|{w}| {w}")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        w = moment.motion_of(p[1])[1]
        return JointForce(force=p[0] * jnp.abs(w) * w), state


@final
class LawSquareFling(Coupling):
    """tau = g w'^2 of the other joint's speed w'."""

    name: ClassVar[str] = "law_square_fling"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), OTHER_JOINT)
    equation: ClassVar[str] = "tau = g w'^2, w' the speed of joint `with`"
    resembles: ClassVar[str] = "a joint that another one flings outwards"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["g"], f"w{other_joint(values)}^2")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * jnp.square(moment.motion_of(p[1])[1])), state


@final
class LawStir(Coupling):
    """tau = -g |w'| w: a damping in proportion to the other joint's speed w'."""

    name: ClassVar[str] = "law_stir"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), OTHER_JOINT)
    equation: ClassVar[str] = "tau = -g |w'| w, w' the speed of joint `with`"
    resembles: ClassVar[str] = "damping that another joint's speed makes"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["g"], f"|w{other_joint(values)}| w")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(damping=p[0] * jnp.abs(moment.motion_of(p[1])[1])), state


@final
class LawWhirl(Coupling):
    """tau = g w' w: like the forces of Coriolis."""

    name: ClassVar[str] = "law_whirl"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), OTHER_JOINT)
    equation: ClassVar[str] = "tau = g w' w, w' the speed of joint `with`"
    resembles: ClassVar[str] = "a force of two joints' speeds"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["g"], f"w{other_joint(values)} w")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * moment.motion_of(p[1])[1] * moment.w), state


@final
class LawTie(JointLaw):
    """tau = -k (q' - q0) of the other joint's position q'."""

    name: ClassVar[str] = "law_tie"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("k", "N m/rad"),
        OTHER_JOINT,
        Parameter("q0", "rad", signed=True),
    )
    equation: ClassVar[str] = "tau = -k (q' - q0), q' the position of joint `with`"
    resembles: ClassVar[str] = "a spring to another joint"
    symbols: ClassVar[str] = _SYMBOLS

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint) / (0.1 * half_span(robot, joint))

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (1.0, float(robot.model.njnt)), (-2.0 * np.pi, 2.0 * np.pi)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(1.0 + j, q) for j in reach.others for q in (-0.7, 0.0, 0.7)]

    def formula(self, values: Mapping[str, float]) -> str:
        q0 = values["q0"]
        return signed(-values["k"], f"(q{other_joint(values)} {'-' if q0 >= 0.0 else '+'} {abs(q0):.3g})")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=-p[0] * (moment.motion_of(p[1])[0] - p[2])), state
