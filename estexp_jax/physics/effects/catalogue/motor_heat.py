"""A motor that is hot long before it has given its largest torque, told as a motor that fades."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.catalogue.motor_fade import MotorFade
from estexp_jax.physics.effects.sites import actuator_sites
from estexp_jax.physics.model.robot import Robot

_FADE = MotorFade()


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

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return actuator_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return *_FADE.bounds(robot, site), (0.02, 1.0)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return _FADE.sentence(site, values)

    def told(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "motor_fade", {name: values[name] for name in ("loss", "tau")}

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        (loss, tau, share), (heat,) = p, state
        load = jnp.square(moment.torque / jnp.maximum(share * moment.limit, 1e-9))
        after = load + (heat - load) * jnp.exp(-moment.dt / tau)
        return JointForce(motor=1.0 - loss * jnp.minimum(heat, 1.0)), (after,)
