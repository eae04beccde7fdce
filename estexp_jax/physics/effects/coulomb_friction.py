"""Coulomb friction: a joint resists motion with the same torque whatever its speed."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import mujoco
from mujoco import mjx

from estexp_jax.physics import scales
from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.sites import joint_dofs, scalar_joint_sites
from estexp_jax.physics.robot import Robot, spec_element


@final
class CoulombFriction(Edit):
    """tau = -T sign(w), as MuJoCo's friction loss: a constraint, so that it also holds at rest and never chatters."""

    name: ClassVar[str] = "coulomb_friction"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("T", "N m"),)
    equation: ClassVar[str] = "tau = -T sign(w)"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: joint/frictionloss"
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 0.8 * scales.joint_torque(robot, robot.index("joint", site))),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the joint {site} resists motion with {values['T']:.3g} N m whatever its speed"

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        return model.replace(dof_frictionloss=model.dof_frictionloss.at[joint_dofs(robot)].add(values[:, 0]))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        spec_element(spec, robot, "joint", site).frictionloss += values["T"]
