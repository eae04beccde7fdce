"""Springs that act on one side of a position only."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.laws.base import Bounds, JointLaw, Reach, amplitude, away, half_span, signed, torque
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_TIGHT = 0.1
"""Share of half a joint's range within which such a spring may reach full torque."""


class _OneSided(JointLaw):
    """A spring with its stiffness and the position at which it begins."""

    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("k", "N m/rad"), Parameter("q0", "rad", signed=True))

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint) / (_TIGHT * half_span(robot, joint))

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (scales.joint_span(robot, joint),)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(q,) for q in reach.places(9)]


@final
class LawUpperSpring(_OneSided):
    """tau = -k max(q - q0, 0)."""

    name: ClassVar[str] = "law_upper_spring"
    equation: ClassVar[str] = "tau = -k max(q - q0, 0)"
    resembles: ClassVar[str] = "a spring that begins beyond some position"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["k"], f"max{away('q', values['q0'])[:-1]}, 0)")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=-p[0] * jnp.maximum(moment.q - p[1], 0.0)), state


@final
class LawLowerSpring(_OneSided):
    """tau = -k min(q - q0, 0)."""

    name: ClassVar[str] = "law_lower_spring"
    equation: ClassVar[str] = "tau = -k min(q - q0, 0)"
    resembles: ClassVar[str] = "a spring that begins below some position"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["k"], f"min{away('q', values['q0'])[:-1]}, 0)")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(force=-p[0] * jnp.minimum(moment.q - p[1], 0.0)), state
