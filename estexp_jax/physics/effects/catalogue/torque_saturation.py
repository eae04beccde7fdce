"""Torque saturation: a motor's torque ends earlier than modelled."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import NEVER, Edit, Parameter
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import actuator_sites, driven_actuators
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot, spec_element


@register_effect
@final
class TorqueSaturation(Edit):
    """|torque of the motor at its joint| <= limit, as MuJoCo's force range."""

    name: ClassVar[str] = "torque_saturation"
    kind: ClassVar[str] = "actuator"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("limit", "N m", neutral=NEVER),)
    equation: ClassVar[str] = "torque = clip(torque_nominal, -limit, limit)"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: actuator/forcerange"
    arms: ClassVar[tuple[str, ...]] = ("actuator_forcerange",)

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return actuator_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        most = scales.motor_limit(robot, robot.index("actuator", site))
        return ((0.01 * most, most),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the motor {site} gives no more than {values['limit']:.3g} N m"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(float(x),) for x in np.geomspace(*self.bounds(robot, site)[0], 8)]

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        driven = np.array(driven_actuators(robot), dtype=int)
        most = (values[:, 0] / jnp.abs(model.actuator_gear[robot.model.actuator_outadr[driven], 0]))[:, None]
        limits = jnp.clip(model.actuator_forcerange[driven], -most, most)
        return model.replace(actuator_forcerange=model.actuator_forcerange.at[driven].set(limits))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        actuator = spec_element(spec, robot, "actuator", site)
        nominal = robot.model.actuator(robot.index("actuator", site))
        most = values["limit"] / abs(float(nominal.gear[0]))
        before = np.array(actuator.forcerange) if nominal.forcelimited[0] else np.array([-np.inf, np.inf])
        actuator.forcelimited = mujoco.mjtLimited.mjLIMITED_TRUE
        actuator.forcerange = np.clip(before, -most, most)
