"""The estimation phase's genome: four genes of four values in [-1, 1].

A gene's values are: whether it is active, which of the six modifications, at which site, and the amount. The first
three are scaled to [0, n - 1] and rounded, as in the paper. This gives the first and the last choice half the
probability of the others.

Source: Bongard and Lipson 2004, section 2.2, "The Estimation Phase".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import paper
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.estimation.damage_sites import DamageSite, canonical_damage, change_of, damage_sites

GENES, VALUES = 4, 4
LENGTH = GENES * VALUES

DamageHypothesis = tuple[tuple[DamageSite, float], ...]
"""Damage sites with amounts, as of `edits.canonical_damage`; empty for no damage."""


@final
class GenomeDecoder:
    """Decodes genomes for one robot.

    Args:
        robot: the nominal robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._kinds = paper()
        self._places = tuple(damage_sites(robot, kind.name) for kind in self._kinds)

    def items(self, genome: np.ndarray) -> DamageHypothesis:
        """The damage of a genome (16,): sorted, each site once, nothing without effect."""
        found = []
        for active, kind, where, much in np.asarray(genome, float).reshape(GENES, VALUES):
            which = _rounded(kind, len(self._kinds))
            choices = self._places[which]
            if _rounded(active, 2) == 1 and choices:
                place = choices[_rounded(where, len(choices))]
                found.append((place, self._kinds[which].amount_of_gene(much)))
        return canonical_damage(self._robot, found)

    def changes(self, genome: np.ndarray) -> tuple[Change, ...]:
        """The changes of the nominal model that a genome (16,) stands for."""
        return tuple(change_of(self._robot, place, amount) for place, amount in self.items(genome))


def _rounded(value: float, n: int) -> int:
    """[-1, 1] scaled to [0, n - 1], rounded half up."""
    return int(np.floor((value + 1.0) / 2.0 * (n - 1) + 0.5))


def hypothesis_key(items: Sequence[tuple[DamageSite, float]]) -> str:
    """A text that is equal for equal hypotheses, to look up those already simulated."""
    return ";".join(f"{place.effect}@{place.name or ''}={amount:.12g}" for place, amount in items)
