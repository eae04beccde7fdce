"""Viscous friction that is larger one way than the other, reported as viscous friction."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.catalogue.viscous_friction import ViscousFriction
from estexp_jax.physics.effects.friction import reported_shape
from estexp_jax.physics.effects.guesses import SHARES, Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import scalar_joint_sites
from estexp_jax.physics.model.robot import Robot

_VISCOUS = ViscousFriction()


@register_effect
@final
class AsymmetricDamping(Term):
    """tau = -c (1 + a sign(w)) w, added to the joint's own damping; integrated implicitly."""

    name: ClassVar[str] = "asymmetric_damping"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("c", "N m s/rad"), Parameter("a", "", signed=True))
    equation: ClassVar[str] = "tau = -c (1 + a sign(w)) w"
    source: ClassVar[str] = "Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994), section 2.1"
    additive: ClassVar[bool] = True
    nested_in: ClassVar[str] = "viscous_friction"
    variant_of: ClassVar[str] = "viscous_friction"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return *_VISCOUS.bounds(robot, site), (-1.0, 1.0)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return _VISCOUS.sentence(site, values)

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        most = self.bounds(robot, site)[0][1]
        return [(share * most, a) for share, a in product(SHARES, (-0.4, 0.4))]

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        return [(simpler["c"], a) for a in (-0.15, 0.15)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["c"],)]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "viscous_friction", reported_shape(values, "c")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        c, a = p
        return JointForce(damping=c * (1.0 + a * jnp.sign(joint.w))), state
