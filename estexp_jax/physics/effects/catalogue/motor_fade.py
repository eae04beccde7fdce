"""Motor fade: a motor weakens as it heats up."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.guesses import Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import actuator_sites
from estexp_jax.physics.model.robot import Robot

_SOONEST = 0.5
"""Time constant of the fastest heating, s. What weakens a motor sooner is no heat: nearly at once, the term would stand
in for anything that grows with torque."""


@register_effect
@final
class MotorFade(Term):
    """dH/dt = ((tau / tau_max)^2 - H) / t with t = `tau`, force = (1 - loss H) nominal force.

    The heat H is 1 where the motor has given its largest torque tau_max for long; it is 0 where a recording begins.
    """

    name: ClassVar[str] = "motor_fade"
    kind: ClassVar[str] = "actuator"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("loss", ""),
        Parameter("tau", "s", neutral=10.0),
    )
    equation: ClassVar[str] = "force = (1 - loss H) nominal force, dH/dt = ((torque / largest torque)^2 - H) / tau"
    source: ClassVar[str] = "first-order thermal model of a motor's winding: Urata et al., IROS 2008"
    n_states: ClassVar[int] = 1
    nested_in: ClassVar[str] = "motor_weakness"
    grows_in_time: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return actuator_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return (0.0, 1.0), (_SOONEST, 100.0)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return (
            f"the motor {site} loses up to {100 * values['loss']:.3g} % of its strength as it heats up, "
            f"with a time constant of {values['tau']:.3g} s"
        )

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return list(product((0.2, 0.7), (0.5, 2.0, 8.0, 30.0)))

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        return [(min(max(2.0 * simpler["loss"], 0.05), 0.95), tau) for tau in (1.0, 5.0)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["loss"],), (0.5 * values["loss"],)]

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        (loss, tau), (heat,) = p, state
        load = jnp.minimum(jnp.square(joint.torque / jnp.maximum(joint.limit, 1e-9)), 1.0)
        after = load + (heat - load) * jnp.exp(-joint.dt / tau)
        return JointForce(motor=1.0 - loss * heat), (after,)
