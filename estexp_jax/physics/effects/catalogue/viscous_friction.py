"""Viscous friction: a joint resists motion in proportion to its speed."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import mujoco
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.sites import (
    friction_sites,
    joint_dofs,
    joint_subject,
    joints_at,
    per_element,
)
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot, spec_element


@final
class ViscousFriction(Edit):
    """tau = -c w, added to the joint's own damping; integrated implicitly, as MuJoCo does."""

    name: ClassVar[str] = "viscous_friction"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("c", "N m s/rad"),)
    equation: ClassVar[str] = "tau = -c w"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: joint/damping"
    flags: ClassVar[tuple[str, ...]] = ("damper",)

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return friction_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        joints = [robot.index("joint", one) for one in joints_at(robot, site)]
        return ((0.0, max(scales.joint_torque(robot, j) / scales.joint_speed(robot, j) for j in joints)),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"{joint_subject(site)} resists motion with {values['c']:.3g} N m for each rad/s of speed"

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        dofs = joint_dofs(robot)
        return model.replace(dof_damping=model.dof_damping.at[dofs].add(per_element(values[:, 0], len(dofs))))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        for one in joints_at(robot, site):
            joint = spec_element(spec, robot, "joint", one)
            joint.damping = [joint.damping[0] + values["c"], *joint.damping[1:]]
