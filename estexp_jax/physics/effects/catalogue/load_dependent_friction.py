"""Load-dependent friction: gears rub harder the more torque they carry."""

from collections.abc import Mapping, Sequence
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.friction import friction_advice
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import driven_joint_sites
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording


@register_effect
@final
class LoadDependentFriction(Term):
    """tau = -mu |motor torque| sign(w), as a friction loss renewed at each step from that step's motor torque."""

    name: ClassVar[str] = "load_dependent_friction"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("mu", ""),)
    equation: ClassVar[str] = "tau = -mu |motor torque| sign(w)"
    source: ClassVar[str] = "Duclusaud et al., ICRA 2025 (extended friction models for servo actuators)"
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)
    flags: ClassVar[tuple[str, ...]] = ("constraint", "frictionloss")

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return driven_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return ((0.0, 0.95),)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return f"the joint {site} resists motion with {100 * values['mu']:.3g} % of the torque its motor carries"

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return friction_advice(recordings)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        (mu,) = p
        return JointForce(friction=mu * jnp.abs(joint.torque)), state
