"""Joint jam: a joint moves ever harder, up to not at all."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
import mujoco
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.damage import Damage
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.jam import JAMMED, jam_damping, jam_range
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import joint_dofs, scalar_joint_sites
from estexp_jax.physics.model.robot import Robot, spec_element


@register_effect
@final
class JointJam(Edit, Damage):
    """tau = -c(f) w with c growing geometrically from the joint's damping (f = 0) to stuck (f = 1)."""

    name: ClassVar[str] = "joint_jam"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("f", ""),)
    equation: ClassVar[str] = "tau = -c0 (c1 / c0)^f w"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Bongard and Lipson 2004, section 2.2"
    flags: ClassVar[tuple[str, ...]] = ("damper",)
    gene: ClassVar[int | None] = 4

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 1.0),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the joint {site} is jammed by {100 * values['f']:.3g} %"

    def searched_bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        [(_, high)] = self.bounds(robot, site)
        return ((JAMMED, high),)  # what brakes less is viscous friction

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(f,) for f in (0.55, 0.7, 0.85)]

    def at_amount(self, robot: Robot, site: str, amount: float, partner: int) -> dict[str, float]:
        return {"f": amount}

    def combine(self, a: float, b: float) -> float:
        return max(a, b)

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        start, full = np.array([jam_range(robot, joint) for joint in robot.scalar_joints]).reshape(-1, 2).T
        added = start * jnp.expm1(jnp.maximum(values[:, 0], 0.0) * np.log(full / start))
        return model.replace(dof_damping=model.dof_damping.at[joint_dofs(robot)].add(added))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        joint = spec_element(spec, robot, "joint", site)
        joint.damping = [joint.damping[0] + jam_damping(robot, site, values["f"]), *joint.damping[1:]]
