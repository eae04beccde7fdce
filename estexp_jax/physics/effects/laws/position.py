"""Forces that depend on the position of a joint."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.laws.base import (
    Bounds,
    JointLaw,
    MotionRange,
    amplitude,
    difference_text,
    half_span,
    largest_torque,
    signed_text,
)
from estexp_jax.physics.effects.passive import add_spring
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_STEEP = 0.1
"""Share of half a joint's range over which a force may rise to full torque."""


def _position_bounds(robot: Robot, joint: int) -> tuple[float, float]:
    return scales.joint_span(robot, joint)


def _width_bounds(robot: Robot, joint: int) -> tuple[float, float]:
    half = half_span(robot, joint)
    return 0.005 * half, half


def _initial_spots(motion: MotionRange) -> list[tuple[float, ...]]:
    return [(q, share * motion.span) for q in motion.positions(9) for share in (0.04, 0.1, 0.25)]


@final
class LawSquare(JointLaw):
    """tau = k (q - q0)^2, of either sign."""

    name: ClassVar[str] = "law_square"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("k", "N m/rad2"), Parameter("q0", "rad", signed=True))
    equation: ClassVar[str] = "tau = k (q - q0)^2"
    resembles: ClassVar[str] = "a force that grows away from some position, to one side"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint) / (_STEEP * half_span(robot, joint)) ** 2

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (_position_bounds(robot, joint),)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(q,) for q in (motion.low, *motion.positions(9), motion.high)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(values["k"], f"{difference_text('q', values['q0'])}^2")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * jnp.square(joint.q - p[1])), state


@final
class LawCube(JointLaw):
    """tau = -k (q - q0)^3: a spring that hardens, or one that gives way."""

    name: ClassVar[str] = "law_cube"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("k", "N m/rad3"), Parameter("q0", "rad", signed=True))
    equation: ClassVar[str] = "tau = -k (q - q0)^3"
    in_mjcf: ClassVar[bool] = True
    resembles: ClassVar[str] = "a spring that hardens as it is stretched"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint) / (_STEEP * half_span(robot, joint)) ** 3

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (_position_bounds(robot, joint),)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(q,) for q in (motion.low, *motion.positions(9), 0.0, motion.high)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["k"], f"{difference_text('q', values['q0'])}^3")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=-p[0] * (joint.q - p[1]) ** 3), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_spring(robot, spec, site, (0.0, 0.0, values["k"]), values["q0"])


@final
class LawBump(JointLaw):
    """tau = A exp(-((q - q0) / s)^2): a push at one place."""

    name: ClassVar[str] = "law_bump"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("A", "N m"),
        Parameter("q0", "rad", signed=True),
        Parameter("s", "rad", neutral=0.1),
    )
    equation: ClassVar[str] = "tau = A exp(-((q - q0) / s)^2)"
    resembles: ClassVar[str] = "a push at one position"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return _position_bounds(robot, joint), _width_bounds(robot, joint)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return _initial_spots(motion)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(values["A"], f"exp(-({difference_text('q', values['q0'])}/{values['s']:.3g})^2)")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=p[0] * jnp.exp(-jnp.square((joint.q - p[1]) / p[2]))), state


@final
class LawDetent(JointLaw):
    """tau = -A x exp(-x^2), x = (q - q0) / s: a magnet or a notch that pulls to one place."""

    name: ClassVar[str] = "law_detent"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("A", "N m"),
        Parameter("q0", "rad", signed=True),
        Parameter("s", "rad", neutral=0.1),
    )
    equation: ClassVar[str] = "tau = -A x exp(-x^2), x = (q - q0) / s"
    resembles: ClassVar[str] = "a detent that pulls to, or pushes from, one position"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return 2.0 * largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return _position_bounds(robot, joint), _width_bounds(robot, joint)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return _initial_spots(motion)

    def formula(self, values: Mapping[str, float]) -> str:
        x = f"({difference_text('q', values['q0'])}/{values['s']:.3g})"
        return signed_text(-values["A"], f"{x} exp(-{x}^2)")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        x = (joint.q - p[1]) / p[2]
        return JointForce(force=-p[0] * x * jnp.exp(-jnp.square(x))), state


class _OneSided(JointLaw):
    """A spring with its stiffness and the position at which it begins."""

    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("k", "N m/rad"), Parameter("q0", "rad", signed=True))

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint) / (_STEEP * half_span(robot, joint))

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (scales.joint_span(robot, joint),)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(q,) for q in motion.positions(9)]


@final
class LawUpperSpring(_OneSided):
    """tau = -k max(q - q0, 0)."""

    name: ClassVar[str] = "law_upper_spring"
    equation: ClassVar[str] = "tau = -k max(q - q0, 0)"
    resembles: ClassVar[str] = "a spring that begins beyond some position"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["k"], f"max{difference_text('q', values['q0'])[:-1]}, 0)")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=-p[0] * jnp.maximum(joint.q - p[1], 0.0)), state


@final
class LawLowerSpring(_OneSided):
    """tau = -k min(q - q0, 0)."""

    name: ClassVar[str] = "law_lower_spring"
    equation: ClassVar[str] = "tau = -k min(q - q0, 0)"
    resembles: ClassVar[str] = "a spring that begins below some position"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["k"], f"min{difference_text('q', values['q0'])[:-1]}, 0)")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=-p[0] * jnp.minimum(joint.q - p[1], 0.0)), state
