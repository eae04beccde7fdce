"""Armature: the rotor's inertia, seen through the gear."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import mujoco
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import joint_dofs, scalar_joint_sites, smallest_of_joints
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot, spec_element


@register_effect
@final
class Armature(Edit):
    """tau = -I dw/dt: inertia I added to the joint's own armature."""

    name: ClassVar[str] = "armature"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("I", "kg m2"),)
    equation: ClassVar[str] = "tau = -I dw/dt"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: joint/armature"
    additive: ClassVar[bool] = True
    stales_inertia: ClassVar[bool] = True
    model_attribute: ClassVar[tuple[str, str] | None] = ("joint", "armature")

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, scales.rotor_inertia(robot, robot.index("joint", site))),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the joint {site} carries {values['I']:.3g} kg m2 of rotor inertia that the model lacks"

    def nominal_value(self, robot: Robot, site: str) -> float:
        return smallest_of_joints(robot, robot.model.dof_armature, site)

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        return model.replace(dof_armature=model.dof_armature.at[joint_dofs(robot)].add(values[:, 0]))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        spec_element(spec, robot, "joint", site).armature += values["I"]
