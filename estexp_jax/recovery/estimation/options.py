"""The options of the set search: sites of modifications with the ranges of their amounts.

The paper's catalogue consists of its six modifications, with masses that increase only. The full catalogue adds
decreasing masses, faults of a hidden neuron, motors that repeat another's command, biased or stuck sensors, and a
slippery floor. (A joint's friction is covered by the paper's jam, which is strong damping.)
"""

from __future__ import annotations

from typing import NamedTuple, final

from estexp_jax.physics.effects.registry import PAPER
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Catalogue
from estexp_jax.recovery.estimation.edits import DamageSite, canonical_damage, damage_sites
from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.search.set_moves import Option, OptionSet

EXTENDED = ("neuron_fault", "tied_outputs", "sensor_bias", "sensor_stuck", "ground_friction")
"""What the full catalogue adds to the paper's."""

_SHARE = Option(0.0, 1.0, (0.2, 0.4, 0.7, 1.0))
_OPTIONS: dict[str, Option] = {
    "part_lost": Option(1.0, 1.0, (1.0,)),
    "body_mass": Option(-0.9, 1.0, (-0.6, -0.3, 0.4, 0.7, 1.0)),
    "motor_weakness": _SHARE,
    "sensor_gain": _SHARE,
    "joint_jam": _SHARE,
    "gravity_tilt": Option(-1.0, 1.0, (-1.0, -0.67, -0.33, 0.33, 0.67, 1.0)),
    "neuron_fault": _SHARE,
    "tied_outputs": Option(1.0, 1.0, (1.0,)),
    "sensor_bias": Option(-1.0, 1.0, (-0.8, -0.4, -0.15, 0.15, 0.4, 0.8)),
    "sensor_stuck": Option(-1.0, 1.0, (-1.0, -0.6, -0.2, 0.2, 0.6, 1.0)),
    "ground_friction": Option(0.0, 0.95, (0.3, 0.5, 0.7, 0.85)),
}
"""Range of each modification's amount, and the amounts tried first."""
_GROWING = Option(0.0, 1.0, (0.4, 0.7, 1.0))


@final
class DamageOptions(NamedTuple):
    """A robot's options; the search refers to them by index."""

    robot: Robot
    places: tuple[DamageSite, ...]
    options: tuple[Option, ...]

    def items(self, hypothesis: OptionSet) -> DamageHypothesis:
        """The damage that a hypothesis of the search stands for, in its shortest form."""
        return canonical_damage(self.robot, [(self.places[index], amount) for index, amount in hypothesis])


def damage_options(robot: Robot, catalogue: Catalogue) -> DamageOptions:
    """The candidate differences from a robot's nominal model."""
    names = PAPER if catalogue == "paper" else (*PAPER, *EXTENDED)
    found = tuple(place for name in names for place in damage_sites(robot, name))
    options = {**_OPTIONS, "body_mass": _GROWING} if catalogue == "paper" else _OPTIONS
    return DamageOptions(robot, found, tuple(options[place.effect] for place in found))
