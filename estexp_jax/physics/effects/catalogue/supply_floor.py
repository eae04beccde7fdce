"""A supply that sags no further than to some share, reported as a supply that sags."""

from collections.abc import Mapping, Sequence
from itertools import product
from typing import ClassVar, final

import jax.numpy as jnp

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter, Term
from estexp_jax.physics.effects.catalogue.supply_sag import ONE_BY_ONE, SupplySag, most_sag, supply_sites
from estexp_jax.physics.effects.guesses import SHARES, Bounds, Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording

_SAG = SupplySag()
_NO_FLOOR = 0.01
"""A floor that is at most this is none."""


@register_effect
@final
class SupplyFloor(Term):
    """force = max(1 - R L, floor) nominal force: at some load the supply limits its current, and holds its voltage."""

    name: ClassVar[str] = "supply_floor"
    kind: ClassVar[str] = "environment"
    parameters: ClassVar[tuple[Parameter, ...]] = (*SupplySag.parameters, Parameter("floor", ""))
    equation: ClassVar[str] = "force = max(1 - R L, floor) nominal force, L = sum of |nominal torque| of all motors"
    source: ClassVar[str] = SupplySag.source
    nested_in: ClassVar[str] = "supply_sag"
    variant_of: ClassVar[str] = "supply_sag"

    def sites(self, robot: Robot) -> tuple[str, ...]:
        return supply_sites(robot)

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return (0.0, most_sag(robot)), (0.0, 0.95)

    def sentence(self, site: str, values: Mapping[str, float]) -> str:
        return _SAG.sentence(site, values)

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        return [(share * most_sag(robot), floor) for share, floor in product(SHARES, (0.3, 0.7))]

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        return [(times * simpler["R"], floor) for times in (1.0, 1.5) for floor in (0.3, 0.6)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["R"],), (0.5 * values["R"],)]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "supply_sag", {k: v for k, v in values.items() if k == "R" or v > _NO_FLOOR}

    def advice(self, recordings: Sequence[Recording]) -> tuple[str, ...]:
        return (ONE_BY_ONE,)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        R, floor = p
        return JointForce(motor=jnp.maximum(1.0 - R * joint.load(), floor)), state
