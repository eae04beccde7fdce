"""The paper's genetic algorithm, on costs that need no simulation."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.recovery.estimation.paper_estimation import PaperEstimation
from estexp_jax.recovery.simulator import DamageSimulator


class Counting:
    """The number of changes as a cost; remembers what it was asked."""

    def __init__(self) -> None:
        self.asked: list[DamageHypothesis] = []

    def __call__(self, hypotheses: Sequence[DamageHypothesis], reference: DamageHypothesis = ()) -> np.ndarray:
        self.asked += hypotheses
        return np.array([float(len(items)) for items in hypotheses])

    def evaluate(self, hypothesis: DamageHypothesis, *, thorough: bool = False) -> tuple[float, float]:
        return float(len(hypothesis)), 1.0


def test_equivalent_genomes_are_simulated_once_and_the_best_is_the_diagnosis(
    world: DamageSimulator, settings: Settings
) -> None:
    method, cost = PaperEstimation(world, replace(settings, paper=True, generations=6, population=30), 1), Counting()
    state = method.begin([])
    while not method.done(state):
        state = method.advance(state, cost)
    assert len(cost.asked) == len(set(cost.asked)) < 30 + 5 * 15
    found = method.diagnosis(state)
    assert found.residual == len(found.items) == method.summary(state).best == min(map(len, cost.asked))
    assert found.probability is None and found.alarm is None and method.n_iterations() == 6


def test_the_next_pass_begins_with_the_best_genome(world: DamageSimulator, settings: Settings) -> None:
    method, cost = PaperEstimation(world, replace(settings, paper=True, generations=1, population=30), 1), Counting()
    first = method.advance(method.begin([]), cost)
    again = method.advance(method.begin([method.seed(first)]), cost)
    assert method.diagnosis(again).residual <= method.diagnosis(first).residual
    assert method.diagnosis(first).items in cost.asked
