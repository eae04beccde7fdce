"""The paper's estimation: its genetic algorithm over its genome.

Source: Bongard and Lipson 2004, section 2.2, "The Estimation Phase".
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.genome import LENGTH, GenomeDecoder, hypothesis_key
from estexp_jax.recovery.estimation.hypothesis_cost import HypothesisCost
from estexp_jax.recovery.estimation.method import DamageDiagnosis, Estimation, IterationSummary
from estexp_jax.recovery.simulator import DamageSimulator
from estexp_jax.search import genetic
from estexp_jax.search.genetic import Genetic, Population

TAG = 2
"""In the random numbers' seed: the estimation phase."""


@final
class PaperEstimation(Estimation):
    """The paper's genetic algorithm. Equivalent genomes are simulated once a pass."""

    def __init__(self, simulator: DamageSimulator, settings: Settings, number: int) -> None:
        self._codec = GenomeDecoder(simulator.robot)
        self._generations = settings.generations
        self._genetic = Genetic(LENGTH, settings.population, settings.seed, (TAG, number), settings.mutation)

    def begin(self, seeds: Sequence[Any]) -> dict[str, Any]:
        """See `Estimation`."""
        population = genetic.begin_genetic(self._genetic).to_tree()
        return {"population": population, "seeds": [np.asarray(s) for s in seeds], "known": {}}

    def advance(self, state: dict[str, Any], residuals: HypothesisCost) -> dict[str, Any]:
        """See `Estimation`."""
        population = Population.from_tree(state["population"])
        genomes = genetic.ask_genetic(self._genetic, population, state["seeds"])
        items = [self._codec.items(genome) for genome in genomes]
        new = {hypothesis_key(i): i for i in items if hypothesis_key(i) not in state["known"]}
        values = residuals(list(new.values())) if new else np.zeros(0)
        known = {**state["known"], **{k: float(v) for k, v in zip(new, values, strict=True)}}
        scores = np.array([known[hypothesis_key(i)] for i in items])
        next_population = genetic.tell_genetic(self._genetic, population, genomes, scores)
        return {**state, "population": next_population.to_tree(), "known": known}

    def done(self, state: dict[str, Any]) -> bool:
        """See `Estimation`."""
        return state["population"]["generation"] >= self._generations

    def n_iterations(self) -> int | None:
        """See `Estimation`."""
        return self._generations

    def diagnosis(self, state: dict[str, Any]) -> DamageDiagnosis:
        """See `Estimation`."""
        population = Population.from_tree(state["population"])
        return DamageDiagnosis(self._codec.items(population.genomes[0]), float(population.scores[0]), None)

    def seed(self, state: dict[str, Any]) -> Any:
        """See `Estimation`."""
        return state["population"]["genomes"][0]

    def summary(self, state: dict[str, Any]) -> IterationSummary:
        """See `Estimation`."""
        population = Population.from_tree(state["population"])
        return IterationSummary(float(population.scores[0]), float(np.median(population.scores)), population.dominants)
