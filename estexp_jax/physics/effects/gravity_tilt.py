"""Gravity tilt: the ground is not level."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.robot import Robot


@final
class GravityTilt(Edit):
    """Gravity turned about the world's x axis, sideways to a robot that walks along x: the slope of the paper."""

    name: ClassVar[str] = "gravity_tilt"
    kind: ClassVar[str] = "environment"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("angle", "rad", signed=True),)
    equation: ClassVar[str] = "g = R_x(angle) g_nominal"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Bongard and Lipson 2004, section 2.2: the floor is canted"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return ("",)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((-np.pi / 6, np.pi / 6),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the ground tilts by {np.rad2deg(values['angle']):.3g} degrees about x"

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        return model.replace(opt=model.opt.replace(gravity=_turned(model.opt.gravity, values[0, 0])))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        spec.option.gravity = np.asarray(_turned(jnp.asarray(spec.option.gravity), jnp.asarray(values["angle"])))


def _turned(gravity: jax.Array, angle: jax.Array) -> jax.Array:
    c, s = jnp.cos(angle), jnp.sin(angle)
    return jnp.stack([gravity[0], c * gravity[1] - s * gravity[2], s * gravity[1] + c * gravity[2]])
