"""Stribeck friction: dry friction that falls off once a joint moves."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.guesses import SHARES, Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import scalar_joint_sites
from estexp_jax.physics.effects.spec_friction import add_falling_friction
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_ONE_LEVEL = 0.02
"""Share of T that S is at most where anyone would call it Coulomb friction."""


def reported_levels(values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
    """The name, and its values, of friction with these levels: Coulomb friction, where they are one."""
    if 0.0 < values["T"] and values["S"] <= _ONE_LEVEL * values["T"]:
        return "coulomb_friction", {"T": values["T"]}
    return "stribeck_friction", {name: values[name] for name in ("T", "S", "w_s")}


@register_effect
@final
class StribeckFriction(Term):
    """tau = -(T + S exp(-(w / w_s)^2)) sign(w), as a friction loss renewed at each step from that step's speed."""

    name: ClassVar[str] = "stribeck_friction"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("T", "N m"),
        Parameter("S", "N m"),
        Parameter("w_s", "rad/s", neutral=0.1),
    )
    equation: ClassVar[str] = "tau = -(T + S exp(-(w / w_s)^2)) sign(w)"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Armstrong-Helouvry, Dupont and Canudas de Wit, Automatica 30 (1994), equation 5"
    additive: ClassVar[bool] = True
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)
    flags: ClassVar[tuple[str, ...]] = ("constraint", "frictionloss")
    nested_in: ClassVar[str] = "coulomb_friction"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        most = 0.8 * scales.joint_torque(robot, robot.index("joint", site))
        return (0.0, most), (0.0, most), (0.005, 3.0)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        low, high = values["T"], values["T"] + values["S"]
        return (
            f"the joint {site} resists slow motion with {high:.3g} N m and fast motion with {low:.3g} N m, "
            f"the change coming at {values['w_s']:.3g} rad/s"
        )

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        (_, most), (_, extra), _ = self.bounds(robot, site)
        return [(s * most, s * extra, w) for s, w in product(SHARES, (0.03, 0.2, 0.8))]

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        return [(0.8 * simpler["T"], 0.4 * simpler["T"], w) for w in (0.05, 0.3)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["T"] + share * values["S"],) for share in (0.0, 0.5, 1.0)]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return reported_levels(values)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        T, S, w_s = p
        return JointForce(friction=T + S * jnp.exp(-jnp.square(joint.w / w_s))), state

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_falling_friction(robot, spec, site, values["T"], values["S"], values["w_s"])
