"""The set search under replay, on costs that need no simulation."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.damage_options import damage_options
from estexp_jax.recovery.estimation.damage_sites import DamageSite
from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.recovery.estimation.replay_estimation import LinearisedCandidates, ReplayEstimation
from estexp_jax.recovery.simulator import DamageSimulator

WEAK, HEAVY = DamageSite("motor_weakness", "knee_f"), DamageSite("body_mass", "lower_f")
LEG, BEST = ("upper_b", "lower_b"), 0.5
FAR, HIDDEN = 5000.0, 800.0


class TwoThatFit:
    """Two single changes fit, one of them only where the errors of the simulator are known well."""

    def __call__(self, hypotheses: Sequence[DamageHypothesis], reference: DamageHypothesis = ()) -> np.ndarray:
        return np.array([self._cost(items) for items in hypotheses])

    def evaluate(self, hypothesis: DamageHypothesis, *, thorough: bool = False) -> tuple[float, float]:
        unlucky = HEAVY if thorough else WEAK
        cost = self._cost(hypothesis) + HIDDEN * any(place == unlucky for place, _ in hypothesis)
        return cost, cost / FAR

    def _cost(self, items: DamageHypothesis) -> float:
        off = [abs(amount - BEST) for place, amount in items if place in (WEAK, HEAVY)]
        return FAR * min(1.0, *off, 1.0)


def test_the_last_are_judged_by_more_of_the_simulators_errors(world: DamageSimulator, settings: Settings) -> None:
    method = ReplayEstimation(world, replace(settings, robot="foreign"), 1)
    state, residuals = method.begin([]), TwoThatFit()
    while not method.done(state):
        state = method.advance(state, residuals)
    found = method.diagnosis(state)
    [(place, amount)] = found.items
    assert place == WEAK and abs(amount - BEST) < 0.02
    assert found.probability is not None and found.probability > 0.9


def test_sets_of_options_that_say_the_same_count_once(world: DamageSimulator) -> None:
    options = damage_options(world.robot, "full")
    upper, lower, weak = (options.places.index(place) for place in (*(DamageSite("part_lost", p) for p in LEG), WEAK))
    judged = LinearisedCandidates(options, 0.0, TwoThatFit())
    for hypothesis in (((upper, 1.0),), ((upper, 1.0), (lower, 1.0)), ((lower, 1.0),), ((weak, BEST),)):
        judged.score(hypothesis)
    assert [options.items(hypothesis) for hypothesis in judged.ranked()] == [
        ((WEAK, BEST),),
        ((DamageSite("part_lost", LEG[0]), 1.0),),
        ((DamageSite("part_lost", LEG[1]), 1.0),),
    ]
