"""Actuator lag: a motor follows its command gradually."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.effects.base import Array, Arrays, CommandLaw, Parameter
from estexp_jax.physics.effects.delays import add_lag, is_longer_than_step, lag_refusal
from estexp_jax.physics.effects.guesses import Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import ALL_ALIKE, actuator_sites, with_all
from estexp_jax.physics.model.robot import Robot, spec_element


@register_effect
@final
class ActuatorLag(CommandLaw):
    """tau du/dt = command - u; the motor obeys u, its mean over the step."""

    name: ClassVar[str] = "actuator_lag"
    kind: ClassVar[str] = "actuator"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("tau", "s"),)
    equation: ClassVar[str] = "tau du/dt = command - u"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: actuator/dyntype filterexact"
    n_states: ClassVar[int] = 1
    nested_in: ClassVar[str] = "command_delay"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return with_all(actuator_sites(robot))

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 0.5),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        who = f"all motors ({site}) follow their" if site == ALL_ALIKE else f"the motor {site} follows its"
        return f"{who} commands with a lag of {1000 * values['tau']:.3g} ms"

    def identifiable(self, robot: Robot, site: str, values: Mapping[str, float], observed: Observed) -> bool:
        return is_longer_than_step(robot, values["tau"])

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        return [(simpler["delay"],)]  # slow commands are as late

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["tau"],)]

    def act(self, p: Arrays, command: Array, idle: Array, dt: Array, state: Arrays) -> tuple[Array, Arrays]:
        (tau,), (u,) = p, state
        rate = dt / jnp.maximum(tau, 1e-6)
        after = command + (u - command) * jnp.exp(-rate)
        mean = command + (u - command) * (-jnp.expm1(-rate)) / rate
        lags = tau > 0.0
        return jnp.where(lags, mean, command), (jnp.where(lags, after, command),)

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        refusals = (lag_refusal(robot, robot.index("actuator", one)) for one in _actuators(robot, site))
        return next(filter(None, refusals), "")

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        for one in _actuators(robot, site):
            add_lag(spec, spec_element(spec, robot, "actuator", one), values["tau"])


def _actuators(robot: Robot, site: str) -> tuple[str, ...]:
    return actuator_sites(robot) if site == ALL_ALIKE else (site,)
