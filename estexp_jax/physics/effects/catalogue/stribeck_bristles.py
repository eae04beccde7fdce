"""Stribeck friction of bristles, reported as Stribeck friction."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.effects.base import Array, Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.bristles import bristle_at_rest, bristle_friction
from estexp_jax.physics.effects.catalogue.stribeck_friction import reported_levels
from estexp_jax.physics.effects.guesses import Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import scalar_joint_sites
from estexp_jax.physics.effects.spec_friction import add_bristles
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot


@register_effect
@final
class StribeckBristles(Term):
    """Bristles whose level of steady sliding is T + S exp(-(w / w_s)^2), with the presliding way x."""

    name: ClassVar[str] = "stribeck_bristles"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("T", "N m"),
        Parameter("S", "N m"),
        Parameter("w_s", "rad/s", neutral=0.1),
        Parameter("x", "rad", neutral=1e-3),
    )
    equation: ClassVar[str] = "dF/dq = ((T + S exp(-(w / w_s)^2)) sign(w) - F) / x, tau = -F"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Canudas de Wit et al., IEEE Transactions on Automatic Control 40 (1995)"
    n_states: ClassVar[int] = 2
    nested_in: ClassVar[str] = "hysteresis"
    variant_of: ClassVar[str] = "stribeck_friction"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        most = 0.8 * scales.joint_torque(robot, robot.index("joint", site))
        return (0.0, most), (0.0, most), (0.005, 3.0), (5e-5, 0.02)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        low, high = values["T"], values["T"] + values["S"]
        return (
            f"the joint {site} resists slow motion with {high:.3g} N m and fast motion with {low:.3g} N m, "
            f"the change coming at {values['w_s']:.3g} rad/s; it gives by {values['x']:.2g} before it slides"
        )

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        most, shares, speeds = self.bounds(robot, site)[0][1], (0.01, 0.05, 0.2), (0.03, 0.2, 0.8)
        return [(0.7 * s * most, 0.5 * s * most, w, 2e-3) for s, w in product(shares, speeds)]

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        t, way = simpler["T"], simpler["T"] / simpler["sigma"]
        return [(0.8 * t, 0.4 * t, w, way) for w in (0.05, 0.3)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(t, t / values["x"]) for t in (values["T"], values["T"] + values["S"])]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return reported_levels(values)

    def initial(self, p: Arrays, q: Array, w: Array) -> Arrays:
        return bristle_at_rest(q)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        T, S, w_s, x = p
        return bristle_friction(T + S * jnp.exp(-jnp.square(joint.w / w_s)), x, joint, state)

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        low, fall = values["T"], values["S"]
        middle = (low + 0.5 * fall) / values["x"]  # its stiffness follows its level
        add_bristles(robot, spec, site, middle, (low, low + fall, values["w_s"]))
