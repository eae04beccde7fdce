"""Quadratic drag: a joint stirs air or water."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.passive import add_damper
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import scalar_joint_sites
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot


@register_effect
@final
class QuadraticDrag(Term):
    """tau = -c |w| w, as a damping of c |w| renewed at each step, so that it never overshoots."""

    name: ClassVar[str] = "quadratic_drag"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("c", "N m s2/rad2"),)
    equation: ClassVar[str] = "tau = -c |w| w"
    in_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "turbulent drag: Batchelor, An Introduction to Fluid Dynamics, section 5.11"
    additive: ClassVar[bool] = True
    nested_in: ClassVar[str] = "viscous_friction"
    beside_laws: ClassVar[bool] = True

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        joint = robot.index("joint", site)
        return ((0.0, scales.joint_torque(robot, joint) / scales.joint_speed(robot, joint) ** 2),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the joint {site} resists motion with {values['c']:.3g} N m at 1 rad/s, growing with the speed squared"

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        (c,) = p
        return JointForce(damping=c * jnp.abs(joint.w)), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_damper(robot, spec, site, (0.0, values["c"], 0.0))
