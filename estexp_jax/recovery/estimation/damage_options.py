"""The options of the set search: sites of modifications with the ranges of their amounts.

The paper's catalogue consists of its six modifications, with masses that increase only. The full catalogue adds
decreasing masses, faults of a hidden neuron, motors that repeat another's command, biased or stuck sensors, and a
slippery floor. (A joint's friction is covered by the paper's jam, which is strong damping.)
"""

from __future__ import annotations

from typing import NamedTuple, final

from estexp_jax.physics.effects.damage import Damage
from estexp_jax.physics.effects.registry import damages, paper
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Catalogue
from estexp_jax.recovery.estimation.damage_sites import DamageSite, canonical_damage, damage, damage_sites
from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.search.set_moves import Option, OptionSet


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
    is_paper = catalogue == "paper"
    found = tuple(place for e in (paper() if is_paper else damages()) for place in damage_sites(robot, e.name))
    return DamageOptions(robot, found, tuple(_option(damage(place.effect), is_paper) for place in found))


def _option(modification: Damage, is_paper: bool) -> Option:
    narrower = modification.paper_amounts if is_paper else None
    return Option(*(narrower or modification.amounts))
