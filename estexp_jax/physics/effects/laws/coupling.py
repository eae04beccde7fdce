"""Forces that depend on the motion of another joint."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.laws.base import (
    Bounds,
    JointLaw,
    MotionRange,
    amplitude,
    half_span,
    largest_torque,
    signed_text,
)
from estexp_jax.physics.model.robot import Robot

WITH_JOINT = Parameter("with", "1 + joint index", refers="joint")
"""The parameter that says which joint it is."""
_SYMBOLS = "in brackets the joint whose q or w it is"


class CouplingLaw(JointLaw):
    """A term whose only parameter beside its amplitude is the other joint."""

    symbols: ClassVar[str] = _SYMBOLS

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return ((1.0, float(robot.model.njnt)),)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(1.0 + j,) for j in motion.other_joints]


def other_joint(values: Mapping[str, float]) -> str:
    """The other joint in a formula: `[joint 2]`."""
    return f"[joint {round(values['with'])}]"


@final
class LawTow(CouplingLaw):
    """tau = g w' of the other joint's speed w'."""

    name: ClassVar[str] = "law_tow"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s/rad"), WITH_JOINT)
    equation: ClassVar[str] = "tau = g (speed of joint `with`)"
    resembles: ClassVar[str] = "a joint that another one drags along"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(values["g"], f"w{other_joint(values)}")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * joint.motion_of(p[1])[1]), state


@final
class LawFling(CouplingLaw):
    """tau = g |w'| w' of the other joint's speed w'."""

    name: ClassVar[str] = "law_fling"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), WITH_JOINT)
    equation: ClassVar[str] = "tau = g |w'| w', w' the speed of joint `with`"
    resembles: ClassVar[str] = "a joint that another one stirs up"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        w = f"w{other_joint(values)}"
        return signed_text(values["g"], f"|{w}| {w}")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        w = joint.motion_of(p[1])[1]
        return JointForce(force=p[0] * jnp.abs(w) * w), state


@final
class LawSquareFling(CouplingLaw):
    """tau = g w'^2 of the other joint's speed w'."""

    name: ClassVar[str] = "law_square_fling"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), WITH_JOINT)
    equation: ClassVar[str] = "tau = g w'^2, w' the speed of joint `with`"
    resembles: ClassVar[str] = "a joint that another one flings outwards"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(values["g"], f"w{other_joint(values)}^2")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * jnp.square(joint.motion_of(p[1])[1])), state


@final
class LawStir(CouplingLaw):
    """tau = -g |w'| w: a damping in proportion to the other joint's speed w'."""

    name: ClassVar[str] = "law_stir"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), WITH_JOINT)
    equation: ClassVar[str] = "tau = -g |w'| w, w' the speed of joint `with`"
    resembles: ClassVar[str] = "damping that another joint's speed makes"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["g"], f"|w{other_joint(values)}| w")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(damping=p[0] * jnp.abs(joint.motion_of(p[1])[1])), state


@final
class LawWhirl(CouplingLaw):
    """tau = g w' w: like the forces of Coriolis."""

    name: ClassVar[str] = "law_whirl"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", "N m s2/rad2"), WITH_JOINT)
    equation: ClassVar[str] = "tau = g w' w, w' the speed of joint `with`"
    resembles: ClassVar[str] = "a force of two joints' speeds"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(values["g"], f"w{other_joint(values)} w")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * joint.motion_of(p[1])[1] * joint.w), state


@final
class LawTie(JointLaw):
    """tau = -k (q' - q0) of the other joint's position q'."""

    name: ClassVar[str] = "law_tie"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("k", "N m/rad"),
        WITH_JOINT,
        Parameter("q0", "rad", signed=True),
    )
    equation: ClassVar[str] = "tau = -k (q' - q0), q' the position of joint `with`"
    resembles: ClassVar[str] = "a spring to another joint"
    symbols: ClassVar[str] = _SYMBOLS

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint) / (0.1 * half_span(robot, joint))

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (1.0, float(robot.model.njnt)), (-2.0 * np.pi, 2.0 * np.pi)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(1.0 + j, q) for j in motion.other_joints for q in (-0.7, 0.0, 0.7)]

    def formula(self, values: Mapping[str, float]) -> str:
        q0 = values["q0"]
        return signed_text(-values["k"], f"(q{other_joint(values)} {'-' if q0 >= 0.0 else '+'} {abs(q0):.3g})")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=-p[0] * (joint.motion_of(p[1])[0] - p[2])), state
