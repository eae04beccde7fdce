"""Dry friction that sets in gradually with speed, reported as Coulomb friction."""

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
_ONSETS = (0.01, 0.7)
"""Bounds of w_0, rad/s: what grows up to higher speeds is viscous friction."""
_STILL = 1e-3
"""A negligible ratio of speeds: keeps tanh(x) / x a number."""


@register_effect
@final
class SmoothFriction(Term):
    """tau = -T (1 + a sign(w)) tanh(w / w_0), as a damping renewed at each step, so that it never overshoots."""

    name: ClassVar[str] = "smooth_friction"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("T", "N m"),
        Parameter("a", "", signed=True),
        Parameter("w_0", "rad/s", neutral=1.0),
    )
    equation: ClassVar[str] = "tau = -T (1 + a sign(w)) tanh(w / w_0)"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Andersson, Soderberg and Bjorklund, Tribology International 40 (2007), equation 4"
    additive: ClassVar[bool] = True
    nested_in: ClassVar[str] = "asymmetric_friction"
    variant_of: ClassVar[str] = "coulomb_friction"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return *_DRY.bounds(robot, site), (-1.0, 1.0), _ONSETS

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return _DRY.sentence(site, values)

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        most = self.bounds(robot, site)[0][1]
        return [(share * most, 0.0, w) for share, w in product(SHARES, (0.05, 0.15, 0.5))]

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        return [(1.1 * simpler["T"], simpler["a"], w) for w in (0.05, 0.2)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["T"], values["a"])]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "coulomb_friction", reported_shape(values, "T")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        T, a, w_0 = p
        x = jnp.maximum(jnp.abs(joint.w) / w_0, _STILL)
        return JointForce(damping=T * (1.0 + a * jnp.sign(joint.w)) / w_0 * jnp.tanh(x) / x), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_dry_friction(robot, spec, site, values["T"], values["a"])  # MuJoCo's own sets in gradually, too
