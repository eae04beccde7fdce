"""External force: something pulls or pushes a body."""

from collections.abc import Mapping
from typing import ClassVar, final

import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Array, Arrays, BodyForce, Parameter
from estexp_jax.physics.effects.guesses import Vectors, along_axes
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import body_sites
from estexp_jax.physics.effects.spec_forces import add_force, add_pull
from estexp_jax.physics.model.robot import Robot

_REACH, _CONSTANT = 1.0, 0.05
"""Over so many metres (m) a spring that changes by this share of its pull is reported as a constant force."""


@register_effect
@final
class ExternalForce(BodyForce):
    """F = (x, y, z) - k c at the body's centre of mass c, in world axes.

    With k = 0 a constant force; else a spring of stiffness k to the point (x, y, z) / k.
    """

    name: ClassVar[str] = "external_force"
    kind: ClassVar[str] = "environment"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        *(Parameter(axis, "N", signed=True) for axis in "xyz"),
        Parameter("k", "N/m"),
    )
    equation: ClassVar[str] = "F = (x, y, z) - k c"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: xfrc_applied"
    additive: ClassVar[bool] = True
    nested_in: ClassVar[str] = "body_mass"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return body_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        weight = float(robot.model.body_mass.sum()) * max(float(np.linalg.norm(robot.model.opt.gravity)), 1.0)
        return ((-weight, weight),) * 3 + ((0.0, 10.0 * weight),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        x, y, z, k = (values[name] for name in ("x", "y", "z", "k"))
        if k * _REACH > _CONSTANT * float(np.linalg.norm((x, y, z))):
            point = f"({x / k:.3g}, {y / k:.3g}, {z / k:.3g}) m"
            return f"a spring of {k:.3g} N/m pulls the body {site} towards {point}"
        return f"a force of ({x:.3g}, {y:.3g}, {z:.3g}) N acts on the body {site}"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return along_axes(self.bounds(robot, site), 0.1)

    def force_on_body(self, p: Arrays, position: tuple[Array, Array, Array]) -> tuple[Array, Array, Array]:
        x, y, z, k = p
        return x - k * position[0], y - k * position[1], z - k * position[2]

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        force, k = [values[axis] for axis in "xyz"], values["k"]
        if k > 0.0:
            add_pull(robot, spec, site, k, [f / k for f in force])
        else:
            add_force(robot, spec, site, force)
