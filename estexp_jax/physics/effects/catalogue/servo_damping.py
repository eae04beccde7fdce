"""A servo's own speed feedback is off: an ordinary error of a value that the model has, never an effect to claim."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.servos import servo_damping_at, servos
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.actuators import gear_of
from estexp_jax.physics.model.robot import Robot, spec_element


@register_effect
@final
class ServoDamping(Edit):
    """tau = -k w within the motor's force and its limits: `kv` is larger by k over the squared gear.

    Unlike back-EMF it shows in a torque reading; the two are reported under that name.
    """

    name: ClassVar[str] = "servo_damping"
    kind: ClassVar[str] = "actuator"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("k", "N m s/rad", signed=True),)
    equation: ClassVar[str] = "tau = -k w in the motor's force"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo, XML reference, actuator/position: kv"
    additive: ClassVar[bool] = True
    claimable: ClassVar[bool] = False
    alike_while_on: ClassVar[str] = "viscous_friction"
    model_attribute: ClassVar[tuple[str, str] | None] = ("actuator", "*")

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return tuple(robot.names("actuator")[a] for a in servos(robot))

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        limit = scales.motor_limit(robot, robot.index("actuator", site))
        return ((-limit, limit),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        k = values["k"]
        return (
            f"the servo {site} damps its joint with {abs(k):.3g} N m s/rad {'more' if k >= 0 else 'less'} than modelled"
        )

    def nominal_value(self, robot: Robot, site: str) -> float:
        return servo_damping_at(robot, site)

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "back_emf", values

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        own = np.array(servos(robot), dtype=int)
        gear = robot.model.actuator_gear[robot.model.actuator_outadr[own], 0]
        slope = jnp.zeros(robot.model.nactuator, values.dtype).at[own].add(values[:, 0] / gear**2)
        return model.replace(actuator_biasprm=model.actuator_biasprm.at[:, 2].add(-slope))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        actuator = spec_element(spec, robot, "actuator", site)
        bias = np.array(actuator.biasprm)
        bias[2] -= values["k"] / gear_of(robot.model, robot.index("actuator", site)) ** 2
        actuator.biasprm = bias
