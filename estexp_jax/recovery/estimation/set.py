"""Estimation by a set search, for a robot that its simulator describes exactly.

All places first, amounts later, a price on each change: see `search.set_search`. A ladder of three searches, each
only where the one before leaves an error: single changes of the whole catalogue; sets of the paper's six kinds; sets of
all kinds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np

from estexp_jax.physics.effects.registry import effect, paper
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.base import DamageDiagnosis, Estimation, HypothesisCost, Round
from estexp_jax.recovery.estimation.options import damage_options
from estexp_jax.recovery.simulator import DamageSimulator
from estexp_jax.search import set_search
from estexp_jax.search.set_search import SetSearch

_WEIGHT = 4.0
"""Of an objective in a probability: as if so many samples were independent."""
_ALARM = 0.0005
"""Residual above which no hypothesis of the catalogue reproduces the recordings."""
_SOLVED = 0.0001
"""Residual below which no larger catalogue is tried."""
_EXACT: dict[str, Any] = {"floor": 0.0002, "negligible": 0.1, "beam": 32, "scanned": 16}
"""Settings of each search: the simulator is exact, so what is left of an error is a change still missing."""
_SEEDS = 12
_RIVALS, _UNLIKELY = 3, 0.01
"""Rivals told at most, and the probability below which they are not."""


@final
class SetEstimation(Estimation):
    """The set search: all places first, amounts later, a price on each change."""

    def __init__(self, simulator: DamageSimulator, settings: Settings) -> None:
        self._menu = damage_options(simulator.robot, settings.catalogue)
        options = self._menu.options
        names = [e.name for e in paper()]
        inside = sum(place.effect in names for place in self._menu.places)  # they come first
        lost = tuple(i for i, place in enumerate(self._menu.places) if effect(place.effect).removes_part)
        single, simple = SetSearch(options, most=1, **_EXACT), SetSearch(options[:inside], kept=lost, **_EXACT)
        everything = SetSearch(options, kept=lost, **_EXACT)
        self._ladder = (single, simple) if inside == len(options) else (single, simple, everything)

    def begin(self, seeds: Sequence[Any]) -> dict[str, Any]:
        """See `Estimation`."""
        search = set_search.begin_set_search().to_tree()
        return {"search": search, "rung": 0, "seeds": list(seeds), "told": [np.inf, np.inf, 0]}

    def advance(self, state: dict[str, Any], residuals: HypothesisCost) -> dict[str, Any]:
        """See `Estimation`."""
        before = set_search.SetSearchState.from_tree(state["search"])
        seeds = [tuple((int(o), float(a)) for o, a in seed) for seed in state["seeds"]]
        search = self._ladder[state["rung"]]
        asked = set_search.ask_set_search(search, before, seeds)
        values = residuals([self._menu.items(items) for items in asked])
        after = set_search.tell_set_search(search, before, asked, values)
        least = min((f.residual for f in before.pool), default=-np.inf)
        left = [f.residual for f in after.pool]
        told = [left[0], float(np.median(left)), int(np.sum(np.asarray(values) < least))]
        state = {**state, "search": after.to_tree(), "told": told}
        return self._climbed(state, after) if set_search.done(after) else state

    def done(self, state: dict[str, Any]) -> bool:
        """See `Estimation`."""
        return state["search"]["stage"] == "done"

    def rounds(self) -> int | None:
        """See `Estimation`."""
        return None

    def diagnosis(self, state: dict[str, Any]) -> DamageDiagnosis:
        """See `Estimation`."""
        found = set_search.SetSearchState.from_tree(state["search"])
        shares = set_search.set_probabilities(self._ladder[-1], found, _WEIGHT)
        first, *others = [(self._menu.items(f.items), float(p)) for f, p in zip(found.pool, shares, strict=True)]
        rivals = tuple((items, p) for items, p in others if p >= _UNLIKELY and items != first[0])[:_RIVALS]
        residual = found.pool[0].residual
        return DamageDiagnosis(first[0], residual, first[1], rivals, residual > _ALARM)

    def seed(self, state: dict[str, Any]) -> Any:
        """See `Estimation`."""
        return state["search"]["pool"][0]["items"]

    def summary(self, state: dict[str, Any]) -> Round:
        """See `Estimation`."""
        best, median, dominants = state["told"]
        return Round(best, median, dominants)

    def _climbed(self, state: dict[str, Any], found: set_search.SetSearchState) -> dict[str, Any]:
        """The next search of the ladder where this one leaves an error, with its best hypotheses as seeds."""
        best = found.pool[0]
        if best.residual <= _SOLVED or state["rung"] + 1 == len(self._ladder):
            return state
        options = len(self._ladder[state["rung"] + 1].options)
        kept = [f.items for f in found.pool if all(index < options for index, _ in f.items)][:_SEEDS]
        seeds = [[list(item) for item in items] for items in kept]
        return {**state, "search": set_search.begin_set_search().to_tree(), "rung": state["rung"] + 1, "seeds": seeds}
