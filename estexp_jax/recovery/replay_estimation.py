"""Estimation for a robot that its simulator describes only roughly: a set search under replay.

Costs depend on what the simulator's own errors do, and that depends on what is broken. So the search is repeated about
its own result until the set stays the same; then the finalists are judged, each about itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np

from estexp_jax.inference import set_search
from estexp_jax.inference.set_moves import Items as Indexed
from estexp_jax.inference.set_search import SetSearch
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation import Diagnosis, Estimation, Residuals, Round
from estexp_jax.recovery.options import menu
from estexp_jax.recovery.simulator import Simulator

_PRICE, _PRICE_OF_TRIAL = 40.0, 20.0
"""Cost of one more change, at least, and for each trial: errors of the simulator that its ensemble misses are alike in
all samples of a trial."""
_SEARCHES, _KEPT, _FINALISTS = 3, 12, 8
_FEWER: dict[str, Any] = {"bases": 2, "beam": 10, "scanned": 0, "finalists": 3, "refinements": 3, "polishes": 2}
"""Settings of each search: the first ones only have to find the neighbourhood."""
_TEMPER = 10.0
"""By how much costs are divided in probabilities; see experiments/diagnosis."""
_ALARM = 2.0
"""Cost of a sample above which no hypothesis of the catalogue reproduces the recordings."""
_RIVALS, _UNLIKELY = 3, 0.01
"""Rivals told at most, and the probability below which they are not."""


@final
class ReplayEstimation(Estimation):
    """See the module."""

    def __init__(self, simulator: Simulator, settings: Settings, number: int) -> None:
        self._menu = menu(simulator.robot, settings.catalogue)
        price = _PRICE + _PRICE_OF_TRIAL * number
        self._search = SetSearch(self._menu.options, price=price, floor=0.0, costs=True, **_FEWER)

    def begin(self, seeds: Sequence[Any]) -> dict[str, Any]:
        """See `Estimation`."""
        search = set_search.begin().to_tree()
        return {"search": search, "seeds": list(seeds), "about": [], "searches": 1, "dominants": 0, "judged": None}

    def advance(self, state: dict[str, Any], residuals: Residuals) -> dict[str, Any]:
        """See `Estimation`."""
        before = set_search.State.from_tree(state["search"])
        about = self._menu.items(_plain(state["about"]))
        if set_search.done(before):
            return self._judged(state, before, residuals)
        asked = set_search.ask(self._search, before, [_plain(seed) for seed in state["seeds"]])
        values = residuals([self._menu.items(items) for items in asked], about)
        after = set_search.tell(self._search, before, asked, values)
        least = min((f.residual for f in before.pool), default=-np.inf)
        state = {**state, "search": after.to_tree(), "dominants": int(np.sum(np.asarray(values) < least))}
        return self._again(state, after) if set_search.done(after) else state

    def done(self, state: dict[str, Any]) -> bool:
        """See `Estimation`."""
        return state["judged"] is not None

    def rounds(self) -> int | None:
        """See `Estimation`."""
        return None

    def diagnosis(self, state: dict[str, Any]) -> Diagnosis:
        """See `Estimation`."""
        judged = [(self._menu.items(_plain(j["items"])), j["cost"], j["misfit"]) for j in state["judged"]]
        worth = np.array([cost for _, cost, _ in judged]) - judged[0][1]
        shares = np.exp(-worth / (2.0 * _TEMPER))
        shares /= shares.sum()
        rivals = [(items, float(p)) for (items, _, _), p in zip(judged, shares, strict=True)][1:]
        told = tuple((items, p) for items, p in rivals if p >= _UNLIKELY)[:_RIVALS]
        items, _, misfit = judged[0]
        return Diagnosis(items, misfit, float(shares[0]), told, misfit > _ALARM)

    def seed(self, state: dict[str, Any]) -> Any:
        """See `Estimation`."""
        return state["judged"][0]["items"]

    def summary(self, state: dict[str, Any]) -> Round:
        """See `Estimation`."""
        costs = [f["residual"] for f in state["search"]["pool"]]
        return Round(costs[0], float(np.median(costs)), state["dominants"])

    def _again(self, state: dict[str, Any], found: set_search.State) -> dict[str, Any]:
        """Search once more about the result, unless it is the same set as before."""
        best = [list(item) for item in found.pool[0].items]
        same = [i for i, _ in best] == [i for i, _ in state["about"]]
        if same or state["searches"] >= _SEARCHES:
            return state
        seeds = [[list(item) for item in f.items] for f in found.pool[:_KEPT]]
        again = {"search": set_search.begin().to_tree(), "about": best, "searches": state["searches"] + 1}
        return {**state, **again, "seeds": seeds}

    def _judged(self, state: dict[str, Any], found: set_search.State, residuals: Residuals) -> dict[str, Any]:
        """The finalists, each about itself; those that come down to the same items once."""
        judged: dict[Any, dict[str, Any]] = {}
        for f in found.pool[:_FINALISTS]:
            items = self._menu.items(f.items)
            if items not in judged:
                cost, misfit = residuals.alone(items)
                worth = cost + self._search.price * len(items)
                judged[items] = {"items": [list(i) for i in f.items], "cost": worth, "misfit": misfit}
        return {**state, "judged": sorted(judged.values(), key=lambda j: j["cost"])}


def _plain(items: Any) -> Indexed:
    return tuple((int(option), float(amount)) for option, amount in items)
