"""A lost leg, as a hypothesis and as changes of the model."""

from typing import NamedTuple

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.estimation.damage_sites import DamageSite
from estexp_jax.recovery.estimation.genome import DamageHypothesis

LOST: DamageHypothesis = ((DamageSite("part_lost", "upper_b"), 1.0),)
PLANTED = (Change("part_lost", "upper_b", {"lost": 1.0}),)


class OpenLoopTrials(NamedTuple):
    """A robot that has lost a leg and plays the healthy simulator's commands open loop."""

    weights: np.ndarray
    right: Trial  #: with the readings for which the network gave the commands
    wrong: Trial  #: as if the loop had been closed
