"""Hysteresis: friction that builds up with displacement, like a spring that yields."""

from collections.abc import Mapping
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp
import mujoco

from estexp_jax.physics.effects.base import Array, Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.bristles import bristle_at_rest, bristle_friction
from estexp_jax.physics.effects.guesses import Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.sites import scalar_joint_sites
from estexp_jax.physics.effects.spec_friction import add_bristles
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_AT_ONCE = 5e-3
"""A presliding way, rad or m, too short for anyone to call it anything but Coulomb friction."""


@register_effect
@final
class Hysteresis(Term):
    """dF/dq = sigma (1 - F/T sign(w)), tau = -F: Dahl friction, bristles of presliding way T / sigma."""

    name: ClassVar[str] = "hysteresis"
    kind: ClassVar[str] = "joint"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("T", "N m"),
        Parameter("sigma", "N m/rad", neutral=1.0),
    )
    equation: ClassVar[str] = "dF/dq = sigma (1 - F/T sign(w)), tau = -F"
    in_mjcf: ClassVar[bool] = True
    extends_mjcf: ClassVar[bool] = True
    source: ClassVar[str] = "Dahl, A solid friction model, Aerospace Corporation TOR-0158 (1968)"
    n_states: ClassVar[int] = 2
    nested_in: ClassVar[str] = "coulomb_friction"
    family: ClassVar[str] = "coulomb_friction"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return scalar_joint_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        torque = scales.joint_torque(robot, robot.index("joint", site))
        return (0.0, 0.8 * torque), (0.01 * torque, 200.0 * torque)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return (
            f"the joint {site} resists motion with up to {values['T']:.3g} N m, "
            f"built up like a spring of {values['sigma']:.3g} N m/rad"
        )

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        most, ways = self.bounds(robot, site)[0][1], (0.0015, 0.01, 0.05, 0.2)
        return [(s * most, s * most / x) for s, x in product((0.004, 0.02, 0.07, 0.3), ways)]

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        return [(simpler["T"], simpler["T"] / x) for x in (0.0015, 0.01, 0.05)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["T"],)]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        at_once = values["T"] <= _AT_ONCE * values["sigma"]
        return ("coulomb_friction", {"T": values["T"]}) if at_once else (self.name, values)

    def initial(self, p: Arrays, q: Array, w: Array) -> Arrays:
        return bristle_at_rest(q)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        T, sigma = p
        return bristle_friction(T, jnp.maximum(T, 1e-9) / sigma, joint, state)

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_bristles(robot, spec, site, values["sigma"], (values["T"], values["T"], 1.0))
