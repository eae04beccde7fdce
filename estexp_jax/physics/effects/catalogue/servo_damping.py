"""A servo's own speed feedback is off: an ordinary error of a value that the model has, never an effect to claim."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.sites import driven_actuators
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot, spec_element


@final
class ServoDamping(Edit):
    """tau = -k w within the motor's force and its limits: `kv` is larger by k over the squared gear.

    Unlike back-EMF it shows in a torque reading; the two are told under that name.
    """

    name: ClassVar[str] = "servo_damping"
    kind: ClassVar[str] = "actuator"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("k", "N m s/rad", signed=True),)
    equation: ClassVar[str] = "tau = -k w in the motor's force"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo, XML reference, actuator/position: kv"

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

    def told(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "back_emf", values

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        own = np.array(servos(robot), dtype=int)
        slope = (
            jnp.zeros(robot.model.nu, values.dtype).at[own].add(values[:, 0] / robot.model.actuator_gear[own, 0] ** 2)
        )
        return model.replace(actuator_biasprm=model.actuator_biasprm.at[:, 2].add(-slope))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        actuator = spec_element(spec, robot, "actuator", site)
        bias = np.array(actuator.biasprm)
        bias[2] -= values["k"] / robot.model.actuator_gear[robot.index("actuator", site), 0] ** 2
        actuator.biasprm = bias


def servos(robot: Robot) -> tuple[int, ...]:
    """Indices of the actuators that feed back the speed of a hinge or slide joint."""
    return tuple(a for a in driven_actuators(robot) if robot.model.actuator_biasprm[a, 2] < 0.0)


def servo_damping(robot: Robot) -> np.ndarray:
    """What the model says it is, N m s/rad at the joint, for each of `servos`."""
    own = list(servos(robot))
    return -robot.model.actuator_biasprm[own, 2] * robot.model.actuator_gear[own, 0] ** 2
