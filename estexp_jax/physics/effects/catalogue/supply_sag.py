"""Supply sag: all motors weaken together, the more they load the supply that they share."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import actuator_sites, driven_actuators
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

ONE_BY_ONE = (
    "Record one motor working alone, then the same motion while the others work hard: a supply that sags takes from "
    "each motor what the others draw; a weak motor is weak alone."
)


def supply_sites(robot: Robot) -> tuple[str, ...]:
    """The environment, where several motors may share a supply."""
    return ("",) if len(actuator_sites(robot)) > 1 else ()


def most_sag(robot: Robot) -> float:
    """Largest plausible R, 1/(N m): with each motor at a twentieth of its largest torque, nothing is left."""
    return 20.0 / sum(scales.motor_limit(robot, a) for a in driven_actuators(robot))


@register_effect
@final
class SupplySag(Term):
    """force = max(1 - R L, 0) nominal force of every motor, L the sum of all motors' nominal torques.

    A motor's torque is in proportion to its current, so L is in proportion to the current that all draw from a source
    with internal resistance, and so is the voltage that is lost.
    """

    name: ClassVar[str] = "supply_sag"
    kind: ClassVar[str] = "environment"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("R", "1/(N m)"),)
    equation: ClassVar[str] = "force = max(1 - R L, 0) nominal force, L = sum of |nominal torque| of all motors"
    source: ClassVar[str] = "a source with internal resistance: Horowitz and Hill, The Art of Electronics, section 1.2"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return supply_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, most_sag(robot)),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        floor = f", down to {100 * values['floor']:.3g} %" if values.get("floor") else ""
        return (
            f"the motors share a supply that sags: each loses {100 * values['R']:.3g} % of its force for each N m "
            f"that all of them give together{floor}"
        )

    def equation_with_values(self, values: Mapping[str, float]) -> str:
        return self.equation.replace("R L, 0", "R L, floor") if values.get("floor") else self.equation

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return (ONE_BY_ONE,)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        (R,) = p
        return JointForce(motor=jnp.maximum(1.0 - R * joint.load(), 0.0)), state
