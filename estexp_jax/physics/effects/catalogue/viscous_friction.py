"""Viscous friction: a joint resists motion in proportion to its speed."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, final

import jax
import mujoco
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.damage import ModelError
from estexp_jax.physics.effects.friction import friction_advice, shape_in_equation, shape_in_words
from estexp_jax.physics.effects.jam import JAMMED, jam_damping
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import (
    ALL_ALIKE,
    friction_sites,
    joint_dofs,
    joint_subject,
    joints_at,
    per_element,
    smallest_of_joints,
)
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot, spec_element
from estexp_jax.physics.recording import Recording


@register_effect
@final
class ViscousFriction(Edit, ModelError):
    """tau = -c w, added to the joint's own damping; integrated implicitly, as MuJoCo does.

    It is told with one more number where a form of it has it: tau = -c (1 + a sign(w)) w.
    """

    name: ClassVar[str] = "viscous_friction"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("c", "N m s/rad"),)
    equation: ClassVar[str] = "tau = -c w"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: joint/damping"
    additive: ClassVar[bool] = True
    flags: ClassVar[tuple[str, ...]] = ("damper",)
    beside_laws: ClassVar[bool] = True
    model_attribute: ClassVar[tuple[str, str] | None] = ("joint", "damping")

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return friction_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        joints = [robot.index("joint", one) for one in joints_at(robot, site)]
        return ((0.0, max(scales.joint_torque(robot, j) / scales.joint_speed(robot, j) for j in joints)),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        what = f"{joint_subject(site)} resists motion with {values['c']:.3g} N m for each rad/s of speed"
        return what + shape_in_words(values)

    def equation_with_values(self, values: Mapping[str, float]) -> str:
        return shape_in_equation(values, "c", "w")

    def searched_bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        bounds = self.bounds(robot, site)
        if site == ALL_ALIKE:
            return bounds
        [(low, high)] = bounds  # what brakes harder is a jam
        return ((low, min(high, max(jam_damping(robot, site, JAMMED), 0.01 * high))),)

    def nominal_value(self, robot: Robot, site: str) -> float:
        return smallest_of_joints(robot, robot.model.dof_damping, site)

    def off_by(self, robot: Robot, site: str, error: float) -> dict[str, float]:
        return {"c": error * self.nominal_value(robot, site)}

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return friction_advice(recordings)

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        dofs = joint_dofs(robot)
        return model.replace(dof_damping=model.dof_damping.at[dofs].add(per_element(values[:, 0], len(dofs))))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        for one in joints_at(robot, site):
            joint = spec_element(spec, robot, "joint", one)
            joint.damping = [joint.damping[0] + values["c"], *joint.damping[1:]]
