"""Centre-of-mass shift: a body's mass sits elsewhere than modelled."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.guesses import Vectors, along_axes
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import body_sites
from estexp_jax.physics.model.robot import Robot, spec_element
from estexp_jax.physics.model.spec import set_masses


@register_effect
@final
class ComShift(Edit):
    """Centre of mass = nominal + (x, y, z) in the body's frame; mass and inertia about the centre stay."""

    name: ClassVar[str] = "com_shift"
    kind: ClassVar[str] = "body"
    parameters: ClassVar[tuple[Parameter, ...]] = tuple(Parameter(axis, "m", signed=True) for axis in "xyz")
    equation: ClassVar[str] = "c = c_nominal + (x, y, z)"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: body/inertial/pos"
    stales_inertia: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return body_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        body = robot.index("body", site)
        reach = 3.0 * float(np.sqrt(robot.model.body_inertia[body].max() / robot.model.body_mass[body]))
        return ((-reach, reach),) * 3

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        x, y, z = (1000.0 * values[axis] for axis in "xyz")
        return f"the centre of mass of the body {site} lies ({x:.3g}, {y:.3g}, {z:.3g}) mm from where the model has it"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return along_axes(self.bounds(robot, site), 0.1)

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        bodies = np.array([robot.index("body", site) for site in self.sites(robot)], dtype=int)
        return model.replace(body_ipos=model.body_ipos.at[bodies].add(values))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        body, index = spec_element(spec, robot, "body", site), robot.index("body", site)
        mass = float(body.mass) if body.explicitinertial else float(robot.model.body_mass[index])
        set_masses(body, robot.model, index, mass)
        body.ipos = body.ipos + np.array([values[axis] for axis in "xyz"])
