"""Dry friction that is larger one way than the other, reported as Coulomb friction."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.catalogue.coulomb_friction import CoulombFriction
from estexp_jax.physics.effects.friction import reported_shape
from estexp_jax.physics.effects.guesses import SHARES, Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import scalar_joint_sites
from estexp_jax.physics.effects.spec_friction import add_dry_friction
from estexp_jax.physics.model.robot import Robot

_DRY = CoulombFriction()
_REVERSAL = 0.01
"""Speed below which the direction of motion counts less than fully, rad/s or m/s."""


@register_effect
@final
class AsymmetricFriction(Term):
    """tau = -T (1 + a sign(w)) sign(w), as a friction loss renewed at each step from that step's direction."""

    name: ClassVar[str] = "asymmetric_friction"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (Parameter("T", "N m"), Parameter("a", "", signed=True))
    equation: ClassVar[str] = "tau = -T (1 + a sign(w)) sign(w)"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994), section 2.1"
    additive: ClassVar[bool] = True
    arms: ClassVar[tuple[str, ...]] = CoulombFriction.arms
    flags: ClassVar[tuple[str, ...]] = CoulombFriction.flags
    nested_in: ClassVar[str] = "coulomb_friction"
    variant_of: ClassVar[str] = "coulomb_friction"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return *_DRY.bounds(robot, site), (-1.0, 1.0)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return _DRY.sentence(site, values)

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        most = self.bounds(robot, site)[0][1]
        return [(share * most, a) for share, a in product(SHARES, (-0.4, 0.4))]

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        return [(simpler["T"], a) for a in (-0.15, 0.15)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["T"],)]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "coulomb_friction", reported_shape(values, "T")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        T, a = p
        return JointForce(friction=T * (1.0 + a * jnp.tanh(joint.w / _REVERSAL))), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_dry_friction(robot, spec, site, values["T"], values["a"])
