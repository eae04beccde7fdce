"""What the set search chooses from: places of modifications, with the range of their amounts.

The paper's catalogue is its six modifications, masses growing only. The full one adds what lies outside it: masses
that shrink, a hidden neuron's fault, motors that repeat another's command, sensors that are off by a constant or stuck,
a slippery floor. (A joint's friction is there already: a jam is strong damping.)
"""

from __future__ import annotations

from typing import NamedTuple, final

from estexp_jax.physics.effects.damage import Damage
from estexp_jax.physics.effects.registry import damages, paper
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Catalogue
from estexp_jax.recovery.estimation.edits import Place, damage, merged, places
from estexp_jax.recovery.estimation.genome import Items
from estexp_jax.search.set_moves import Items as Indexed
from estexp_jax.search.set_moves import Option


@final
class DamageOptions(NamedTuple):
    """A robot's options; a hypothesis of the search counts them."""

    robot: Robot
    places: tuple[Place, ...]
    options: tuple[Option, ...]

    def items(self, hypothesis: Indexed) -> Items:
        """Places and amounts of a hypothesis, in its shortest form."""
        return merged(self.robot, [(self.places[index], amount) for index, amount in hypothesis])


def damage_options(robot: Robot, catalogue: Catalogue) -> DamageOptions:
    """What may differ from a robot's nominal model."""
    wide = catalogue != "paper"
    found = tuple(place for e in (damages() if wide else paper()) for place in places(robot, e.name))
    return DamageOptions(robot, found, tuple(_option(damage(place.effect), wide=wide) for place in found))


def _option(e: Damage, *, wide: bool) -> Option:
    amounts = e.amounts if wide else e.paper_amounts or e.amounts
    return Option(*amounts)
