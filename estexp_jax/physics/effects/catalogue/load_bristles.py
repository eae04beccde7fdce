"""Load-dependent friction of bristles, reported as load-dependent friction."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Array, Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.bristles import bristle_at_rest, bristle_friction
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import driven_joint_sites
from estexp_jax.physics.model.robot import Robot


@register_effect
@final
class LoadBristles(Term):
    """Bristles whose level of steady sliding is mu |motor torque|, with the presliding way x."""

    name: ClassVar[str] = "load_bristles"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("mu", ""), Parameter("x", "rad", neutral=1e-3))
    equation: ClassVar[str] = "dF/dq = (mu |motor torque| sign(w) - F) / x, tau = -F"
    source: ClassVar[str] = "Canudas de Wit et al., IEEE Transactions on Automatic Control 40 (1995)"
    n_states: ClassVar[int] = 2
    variant_of: ClassVar[str] = "load_dependent_friction"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return driven_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return (0.0, 0.95), (5e-5, 0.02)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        share, x = 100 * values["mu"], values["x"]
        return f"the joint {site} resists motion with {share:.3g} % of its motor's torque; it gives by {x:.2g} at first"

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(mu, 2e-3) for mu in (0.03, 0.1, 0.3)]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "load_dependent_friction", {"mu": values["mu"]}

    def initial(self, p: Arrays, q: Array, w: Array) -> Arrays:
        return bristle_at_rest(q)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        mu, x = p
        return bristle_friction(mu * jnp.abs(joint.torque), x, joint, state)
