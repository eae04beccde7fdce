"""Hysteresis: friction that builds up with displacement, like a spring that yields."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics import scales
from estexp_jax.physics.effects.base import Array, Arrays, JointForce, JointMoment, Parameter, Term
from estexp_jax.physics.effects.sites import scalar_joint_sites
from estexp_jax.physics.robot import Robot


@final
class Hysteresis(Term):
    """dF/dq = sigma (1 - F/T sign(w)), tau = -F: Dahl friction.

    Between two steps the joint moved by dq, over which the law has the exact solution
    F' = T s + (F - T s) exp(-sigma |dq| / T), s = sign(dq). The step ahead takes F linearised about the present speed,
    with its slope as implicit damping, so that a stiff sigma does not chatter.
    """

    name: ClassVar[str] = "hysteresis"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("T", "N m"),
        Parameter("sigma", "N m/rad", neutral=1.0),
    )
    equation: ClassVar[str] = "dF/dq = sigma (1 - F/T sign(w)), tau = -F"
    source: ClassVar[str] = "Dahl, A solid friction model, Aerospace Corporation TOR-0158 (1968)"
    n_states: ClassVar[int] = 2

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        torque = scales.joint_torque(robot, robot.index("joint", site))
        return (0.0, 0.8 * torque), (0.2 * torque, 200.0 * torque)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return (
            f"the joint {site} resists motion with up to {values['T']:.3g} N m, "
            f"built up like a spring of {values['sigma']:.3g} N m/rad"
        )

    def initial(self, p: Arrays, q: Array, w: Array) -> Arrays:
        return jnp.zeros_like(q), q

    def act(self, p: Arrays, moment: JointMoment, state: Arrays) -> tuple[JointForce, Arrays]:
        (T, sigma), (force, q_before), (w, dt) = p, state, (moment.w, moment.dt)
        force = _followed(T, sigma, force, moment.q - q_before)
        ahead = _followed(T, sigma, force, w * dt)
        slope = sigma * dt * jnp.maximum(T - ahead * jnp.sign(w), 0.0) / jnp.maximum(T, 1e-9)
        return JointForce(force=slope * w - ahead, damping=slope), (force, moment.q)


def _followed(T: Array, sigma: Array, force: Array, moved: Array) -> Array:
    """The force after a displacement in one direction."""
    end = T * jnp.sign(moved)
    return end + (force - end) * jnp.exp(-sigma * jnp.abs(moved) / jnp.maximum(T, 1e-9))
