"""Estimation by a set search, for exact simulators.

All sites are tried first and amounts refined later, with a price on each change: see `search.set_search`. There are
three stages: single changes of the whole catalogue; sets of the paper's six modifications; sets of all modifications.
A stage follows only if the one before leaves an error.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np

from estexp_jax.physics.effects.registry import effect, paper
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.damage_options import damage_options
from estexp_jax.recovery.estimation.hypothesis_cost import HypothesisCost
from estexp_jax.recovery.estimation.method import (
    DamageDiagnosis,
    Estimation,
    IterationSummary,
    catalogue_probability,
)
from estexp_jax.recovery.simulator import DamageSimulator
from estexp_jax.search import set_search
from estexp_jax.search.set_search import SetSearch

_WEIGHT = 4.0
"""Weight of the objective in a probability: effective number of independent samples."""
_ALARM = 0.0005
"""Residual above which no hypothesis of the catalogue reproduces the recordings."""
_SOLVED = 0.0001
"""Residual below which no further stage follows."""
_EXACT: dict[str, Any] = {"floor": 0.0002, "negligible": 0.1, "beam": 32, "scanned": 16}
"""Settings of each search. The simulator is exact, so any error left means that a change is still missing."""
_SEEDS = 12
_MAX_ALTERNATIVES, _LEAST_PROBABILITY = 3, 0.01
"""Alternatives reported at most, and the least probability of a reported one."""


@final
class SetEstimation(Estimation):
    """The set search in three stages: see the module."""

    def __init__(self, simulator: DamageSimulator, settings: Settings) -> None:
        self._menu = damage_options(simulator.robot, settings.catalogue)
        options = self._menu.options
        names = [modification.name for modification in paper()]
        inside = sum(place.effect in names for place in self._menu.places)  # they come first
        lost = tuple(i for i, place in enumerate(self._menu.places) if effect(place.effect).removes_part)
        single = SetSearch(options, max_size=1, **_EXACT)
        simple = SetSearch(options[:inside], always_grown=lost, **_EXACT)
        everything = SetSearch(options, always_grown=lost, **_EXACT)
        self._stages = (single, simple) if inside == len(options) else (single, simple, everything)

    def begin(self, seeds: Sequence[Any]) -> dict[str, Any]:
        """See `Estimation`."""
        search = set_search.begin_set_search().to_tree()
        return {"search": search, "stage": 0, "seeds": list(seeds), "summary": [np.inf, np.inf, 0]}

    def advance(self, state: dict[str, Any], residuals: HypothesisCost) -> dict[str, Any]:
        """See `Estimation`."""
        before = set_search.SetSearchState.from_tree(state["search"])
        seeds = [tuple((int(o), float(a)) for o, a in seed) for seed in state["seeds"]]
        search = self._stages[state["stage"]]
        asked = set_search.ask_set_search(search, before, seeds)
        values = residuals([self._menu.items(items) for items in asked])
        after = set_search.tell_set_search(search, before, asked, values)
        least = min((f.residual for f in before.pool), default=-np.inf)
        left = [f.residual for f in after.pool]
        summary = [left[0], float(np.median(left)), int(np.sum(np.asarray(values) < least))]
        state = {**state, "search": after.to_tree(), "summary": summary}
        return self._next_stage(state, after) if set_search.done(after) else state

    def done(self, state: dict[str, Any]) -> bool:
        """See `Estimation`."""
        return state["search"]["stage"] == "done"

    def n_iterations(self) -> int | None:
        """See `Estimation`."""
        return None

    def diagnosis(self, state: dict[str, Any]) -> DamageDiagnosis:
        """See `Estimation`."""
        found = set_search.SetSearchState.from_tree(state["search"])
        residual, floor = found.pool[0].residual, self._stages[-1].floor
        shares = set_search.set_probabilities(self._stages[-1], found, _WEIGHT)
        shares *= catalogue_probability(residual + floor, _ALARM + floor, _WEIGHT)
        first, *others = [(self._menu.items(f.items), float(p)) for f, p in zip(found.pool, shares, strict=True)]
        probable = [(items, p) for items, p in others if p >= _LEAST_PROBABILITY and items != first[0]]
        return DamageDiagnosis(first[0], residual, first[1], tuple(probable[:_MAX_ALTERNATIVES]), residual > _ALARM)

    def seed(self, state: dict[str, Any]) -> Any:
        """See `Estimation`."""
        return state["search"]["pool"][0]["items"]

    def summary(self, state: dict[str, Any]) -> IterationSummary:
        """See `Estimation`."""
        best, median, dominants = state["summary"]
        return IterationSummary(best, median, dominants)

    def _next_stage(self, state: dict[str, Any], found: set_search.SetSearchState) -> dict[str, Any]:
        """The state of the next stage if this one leaves an error, with its best hypotheses as seeds."""
        best = found.pool[0]
        if best.residual <= _SOLVED or state["stage"] + 1 == len(self._stages):
            return state
        options = len(self._stages[state["stage"] + 1].options)
        kept = [f.items for f in found.pool if all(index < options for index, _ in f.items)][:_SEEDS]
        seeds = [[list(item) for item in items] for items in kept]
        return {**state, "search": set_search.begin_set_search().to_tree(), "stage": state["stage"] + 1, "seeds": seeds}
