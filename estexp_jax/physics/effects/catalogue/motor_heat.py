"""A motor that is hot long before it has given its largest torque, reported as a motor that fades."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.catalogue.motor_fade import MotorFade
from estexp_jax.physics.effects.guesses import Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import actuator_sites
from estexp_jax.physics.model.robot import Robot

_FADE = MotorFade()


@register_effect
@final
class MotorHeat(Term):
    """dH/dt = ((tau / (s tau_max))^2 - H) / t with t = `tau`, s = `share`, force = (1 - loss min(H, 1)) nominal force.

    With s = 1 it is `motor_fade`; with less, the motor is as weak as it gets from that share of its torque on.
    """

    name: ClassVar[str] = "motor_heat"
    kind: ClassVar[str] = "actuator"
    parameters: ClassVar[tuple[Parameter, ...]] = (*MotorFade.parameters, Parameter("share", "", neutral=1.0))
    equation: ClassVar[str] = MotorFade.equation
    source: ClassVar[str] = MotorFade.source
    n_states: ClassVar[int] = 1
    nested_in: ClassVar[str] = "motor_fade"
    variant_of: ClassVar[str] = "motor_fade"
    grows_in_time: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return actuator_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return *_FADE.bounds(robot, site), (0.02, 1.0)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return _FADE.sentence(site, values)

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return list(product((0.3, 0.7), (0.5, 2.0, 8.0), (0.05, 0.15, 0.4)))

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        return [(simpler["loss"], simpler["tau"], share) for share in (0.6, 0.3, 0.15)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["loss"], values["tau"])]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "motor_fade", {name: values[name] for name in ("loss", "tau")}

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        (loss, tau, share), (heat,) = p, state
        load = jnp.square(joint.torque / jnp.maximum(share * joint.limit, 1e-9))
        after = load + (heat - load) * jnp.exp(-joint.dt / tau)
        return JointForce(motor=1.0 - loss * jnp.minimum(heat, 1.0)), (after,)
