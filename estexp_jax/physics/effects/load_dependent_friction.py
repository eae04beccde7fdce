"""Load-dependent friction: gears rub harder the more torque they carry."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax
import jax.numpy as jnp
from mujoco import mjx

from estexp_jax.physics.effects.base import Moment, Parameter, Term
from estexp_jax.physics.effects.sites import joint_dofs, scalar_joint_sites
from estexp_jax.physics.robot import Robot


@final
class LoadDependentFriction(Term):
    """tau = -mu |motor torque| sign(w), as a friction loss renewed at each step from that step's motor torque."""

    name: ClassVar[str] = "load_dependent_friction"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("mu", ""),)
    equation: ClassVar[str] = "tau = -mu |motor torque| sign(w)"
    source: ClassVar[str] = "Duclusaud et al., ICRA 2025 (extended friction models for servo actuators)"
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)

    def sites(self, robot: Robot) -> tuple[str, ...]:
        driven = {robot.joint_of_actuator(a) for a in range(robot.model.nu)}
        names = robot.names("joint")
        return tuple(name for name in scalar_joint_sites(robot) if names.index(name) in driven)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 0.95),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the joint {site} resists motion with {100 * values['mu']:.3g} % of the torque its motor carries"

    def act(self, robot: Robot, model: mjx.Model, moment: Moment, values: jax.Array) -> mjx.Model:
        names = scalar_joint_sites(robot)
        rows = [names.index(site) for site in self.sites(robot)]
        dofs = joint_dofs(robot)[rows]
        friction = values[:, 0] * jnp.abs(moment.motor[dofs])
        return model.replace(dof_frictionloss=model.dof_frictionloss.at[dofs].add(friction))
