"""Body mass: a body is heavier or lighter than modelled."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.damage import Amounts, Damage, ModelError
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import body_sites
from estexp_jax.physics.model.robot import Robot, spec_element
from estexp_jax.physics.model.spec import set_masses


@register_effect
@final
class BodyMass(Edit, Damage, ModelError):
    """mass = nominal + dm, inertia scaled with the mass about the unchanged centre."""

    name: ClassVar[str] = "body_mass"
    kind: ClassVar[str] = "body"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("dm", "kg", signed=True),)
    equation: ClassVar[str] = "m = m_nominal + dm"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Bongard and Lipson 2004, section 2.2"
    stales_inertia: ClassVar[bool] = True
    model_attribute: ClassVar[tuple[str, str] | None] = ("body", "mass")
    gene: ClassVar[int | None] = 1
    amounts: ClassVar[Amounts] = Amounts(-0.9, 1.0, (-0.6, -0.3, 0.4, 0.7, 1.0))
    paper_amounts: ClassVar[Amounts | None] = Amounts(0.0, 1.0, (0.4, 0.7, 1.0))

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return body_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        mass, whole = float(robot.model.body_mass[robot.index("body", site)]), float(robot.model.body_mass.sum())
        return ((-0.9 * mass, max(2.0 * mass, 0.5 * whole)),)  # a light hand may carry much

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        dm = values["dm"]
        return f"the body {site} is {abs(dm):.3g} kg {'heavier' if dm >= 0 else 'lighter'} than modelled"

    def nominal_value(self, robot: Robot, site: str) -> float:
        return float(robot.model.body_mass[robot.index("body", site)])

    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        return {"dm": amount * self.nominal_value(robot, site)}

    def off_by(self, robot: Robot, site: str, error: float) -> dict[str, float]:
        return {"dm": error * self.nominal_value(robot, site)}

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        bodies = np.array([robot.index("body", site) for site in self.sites(robot)])
        nominal = robot.model.body_mass[bodies]
        scale = jnp.ones(robot.model.nbody, values.dtype).at[bodies].add(values[:, 0] / nominal)
        return model.replace(body_mass=model.body_mass * scale, body_inertia=model.body_inertia * scale[:, None])

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        body, index = spec_element(spec, robot, "body", site), robot.index("body", site)
        before = float(body.mass) if body.explicitinertial else float(robot.model.body_mass[index])
        set_masses(body, robot.model, index, before + values["dm"])
