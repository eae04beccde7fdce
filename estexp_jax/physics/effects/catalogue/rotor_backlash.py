"""Backlash with a rotor that rebounds, reported as backlash."""

from collections.abc import Mapping
from typing import ClassVar, final

import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Array, Arrays, JointState, Parameter
from estexp_jax.physics.effects.catalogue.backlash import Play
from estexp_jax.physics.effects.guesses import Bounds, Vectors, spread
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import register_effect
from estexp_jax.physics.effects.rotor import inertia_bounds
from estexp_jax.physics.effects.spec_drives import add_play
from estexp_jax.physics.model.robot import Robot

_REBOUND = 0.35
"""Restitution of steel on steel, as gears meet."""


@register_effect
@final
class RotorBacklash(Play):
    """With a rotor that rebounds, as steel does, and is but part of the joint's armature; reported as backlash.

    Where the model gives the joint no armature, the rotor has an inertia of its own.
    """

    name: ClassVar[str] = "rotor_backlash"
    parameters: ClassVar[tuple[Parameter, ...]] = (*Play.parameters, Parameter("I", "kg m2"), Parameter("e", ""))
    nested_in: ClassVar[str] = "backlash"
    variant_of: ClassVar[str] = "backlash"

    def bounds(self, robot: Robot, site: str) -> tuple[tuple[float, float], ...]:
        return *super().bounds(robot, site), inertia_bounds(robot, site), (0.0, 0.7)

    def initial_guesses(self, robot: Robot, site: str, observed: Observed) -> Vectors:
        play, inertia, _ = self.bounds(robot, site)
        [rotor], plays = spread(inertia, 1), np.geomspace(0.03, 0.5, 5) * play[1]
        return [(gap, rotor, _REBOUND) for gap in plays.tolist()]

    def from_simpler(self, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
        return [(simpler["half_gap"], spread(bounds[1], 1)[0], e) for e in (0.1, _REBOUND)]

    def to_simpler(self, values: Mapping[str, float]) -> Vectors:
        return [(values["half_gap"],)]

    def rotor(self, p: Arrays, joint: JointState) -> Array:
        return p[1]

    def restitution(self, p: Arrays) -> Array:
        return p[2]

    def reported_as(self, values: Mapping[str, float]) -> tuple[str, Mapping[str, float]]:
        return "backlash", {"half_gap": values["half_gap"]}

    def mjcf_refusal(self, robot: Robot, site: str, values: Mapping[str, float]) -> str:
        return ""

    def write_mjcf(self, robot: Robot, spec: mujoco.MjSpec, site: str, values: Mapping[str, float]) -> None:
        add_play(robot, spec, site, values["half_gap"], values["I"])
