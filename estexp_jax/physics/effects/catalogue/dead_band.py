"""Dead band: a motor ignores small commands."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Array, Arrays, CommandLaw, Parameter
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import actuator_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot


@register_effect
@final
class DeadBand(CommandLaw):
    """u = idle + z - clip(z, -half_width, half_width) with z = command - idle.

    `idle` is the command that asks for no torque: where a position servo is, 0 for a motor. So a servo has the dead
    band about its position, as servos do.
    """

    name: ClassVar[str] = "dead_band"
    kind: ClassVar[str] = "actuator"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("half_width", "control unit"),)
    equation: ClassVar[str] = "u = idle + z - clip(z, -half_width, half_width), z = command - idle"
    source: ClassVar[str] = (
        "dead zone: Tao and Kokotovic, Adaptive Control of Systems with Actuator Nonlinearities (1996), section 2.1"
    )

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return actuator_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 0.5 * scales.command_reach(robot, robot.index("actuator", site))),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return (
            f"the motor {site} ignores commands that ask for less than {values['half_width']:.3g} (in its control unit)"
        )

    def act(self, p: Arrays, command: Array, idle: Array, dt: Array, state: Arrays) -> tuple[Array, Arrays]:
        (half_width,) = p
        asked = command - idle
        ignored = jnp.clip(asked, -half_width, half_width)
        return jnp.where(half_width > 0.0, idle + asked - ignored, command), state
