"""Coulomb friction: a joint resists motion with the same torque whatever its speed."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, final

import jax
import mujoco
from mujoco import mjx

from estexp_jax.physics.effects.base import Edit, Parameter
from estexp_jax.physics.effects.friction import friction_advice, shape_in_equation, shape_in_words
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import (
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
class CoulombFriction(Edit):
    """tau = -T sign(w), as MuJoCo's friction loss: a constraint, so that it also holds at rest and never chatters.

    It is told with two more numbers where a form of it has them: tau = -T (1 + a sign(w)) tanh(w / w_0).
    """

    name: ClassVar[str] = "coulomb_friction"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("T", "N m"),)
    equation: ClassVar[str] = "tau = -T sign(w)"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "MuJoCo: joint/frictionloss"
    additive: ClassVar[bool] = True
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)
    flags: ClassVar[tuple[str, ...]] = ("constraint", "frictionloss")
    beside_laws: ClassVar[bool] = True
    model_attribute: ClassVar[tuple[str, str] | None] = ("joint", "frictionloss")

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return friction_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        most = max(scales.joint_torque(robot, robot.index("joint", one)) for one in joints_at(robot, site))
        return ((0.0, 0.8 * most),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        how = shape_in_words(values) or " whatever its speed"
        return f"{joint_subject(site)} resists motion with {values['T']:.3g} N m{how}"

    def equation_with_values(self, values: Mapping[str, float]) -> str:
        return shape_in_equation(values, "T", "sign(w)")

    def nominal_value(self, robot: Robot, site: str) -> float:
        return smallest_of_joints(robot, robot.model.dof_frictionloss, site)

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return friction_advice(recordings)

    def edit(self, robot: Robot, model: mjx.Model, values: jax.Array) -> mjx.Model:
        dofs = joint_dofs(robot)
        return model.replace(dof_frictionloss=model.dof_frictionloss.at[dofs].add(per_element(values[:, 0], len(dofs))))

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        for one in joints_at(robot, site):
            spec_element(spec, robot, "joint", one).frictionloss += values["T"]
