"""Gravity tilt: the ground is not level."""

from collections.abc import Mapping
from itertools import product
from typing import Any, ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.damage import Amounts, Damage
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.model.robot import Robot

STEEPEST = np.pi / 6
"""Steepest slope, rad."""


@register_effect
@final
class GravityTilt(Edit, Damage):
    """Gravity turned about a horizontal axis u, itself turned by `axis` from x towards y.

    axis = 0 is the world's x axis: sideways to a robot that walks along x, the slope of the paper.
    """

    name: ClassVar[str] = "gravity_tilt"
    kind: ClassVar[str] = "environment"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("angle", "rad", signed=True),
        Parameter("axis", "rad", signed=True),
    )
    equation: ClassVar[str] = "g = R_u(angle) g_nominal, u = (cos axis, sin axis, 0)"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Bongard and Lipson 2004, section 2.2: the floor is canted"
    additive: ClassVar[bool] = True
    flags: ClassVar[tuple[str, ...]] = ("gravity",)
    gene: ClassVar[int | None] = 5
    amounts: ClassVar[Amounts] = Amounts(-1.0, 1.0, (-1.0, -0.67, -0.33, 0.33, 0.67, 1.0))

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return ("",)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return (-np.pi / 6, np.pi / 6), (-np.pi / 2, np.pi / 2)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        angle, axis = np.rad2deg(values["angle"]), np.rad2deg(values["axis"])
        axis_name = "x" if axis == 0.0 else f"an axis {axis:.3g} degrees from x"
        return f"the ground tilts by {angle:.3g} degrees about {axis_name}"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return list(product((-0.1, 0.1), (-np.pi / 4, 0.0, np.pi / 4, np.pi / 2)))

    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        return {"angle": amount * STEEPEST}

    def amount_of_gene(self, value: float) -> float:
        return float(value)

    def combine(self, a: float, b: float) -> float:
        return float(np.clip(a + b, -1.0, 1.0))

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        return model.replace(opt=model.opt.replace(gravity=_turned(model.opt.gravity, values[0, 0], values[0, 1])))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        spec.option.gravity = _turned(np.array(spec.option.gravity), values["angle"], values["axis"], np)


def _turned(gravity: Any, angle: Any, axis: Any, xp: Any = jnp) -> Any:
    """Rodrigues' rotation; written so that an angle of 0 changes no bit."""
    u = xp.stack([xp.cos(axis), xp.sin(axis), xp.zeros_like(axis)])
    across = xp.cross(u, gravity)
    return gravity + xp.sin(angle) * across + (1.0 - xp.cos(angle)) * xp.cross(u, across)
