"""The estimation phase's genome: four genes of four values in [-1, 1].

A gene's values are: active?, which of the six modifications, where, how much. The first three are scaled to [0, n - 1]
and rounded, as the text says, which gives the first and the last choice half the probability of the others.

Source: Bongard and Lipson 2004, section 2.2, "The Estimation Phase".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import paper
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.estimation.edits import Place, change_of, merged, places

GENES, VALUES = 4, 4
LENGTH = GENES * VALUES

Items = tuple[tuple[Place, float], ...]
"""Places and amounts: see `edits`."""


@final
class Codec:
    """What genomes mean on one robot.

    Args:
        robot: the nominal robot.
    """

    def __init__(self, robot: Robot) -> None:
        self._robot = robot
        self._kinds = paper()
        self._places = tuple(places(robot, e.name) for e in self._kinds)

    def items(self, genome: np.ndarray) -> Items:
        """Places and amounts of a genome (16,): sorted, each place once, nothing without effect."""
        found = []
        for active, kind, where, much in np.asarray(genome, float).reshape(GENES, VALUES):
            which = _rounded(kind, len(self._kinds))
            choices = self._places[which]
            if _rounded(active, 2) == 1 and choices:
                place = choices[_rounded(where, len(choices))]
                found.append((place, self._kinds[which].amount_of_gene(much)))
        return merged(self._robot, found)

    def changes(self, genome: np.ndarray) -> tuple[Change, ...]:
        """The modifications of the simulator that a genome (16,) stands for."""
        return tuple(change_of(self._robot, place, amount) for place, amount in self.items(genome))


def _rounded(value: float, n: int) -> int:
    """[-1, 1] scaled to [0, n - 1], rounded half up."""
    return int(np.floor((value + 1.0) / 2.0 * (n - 1) + 0.5))


def key(items: Sequence[tuple[Place, float]]) -> str:
    """A text that two genomes share if they say the same, to look up what was simulated already."""
    return ";".join(f"{place.effect}@{place.name or ''}={amount:.12g}" for place, amount in items)
