"""Estimation for a robot that its simulator describes only roughly: a set search under replay.

Costs depend on what the simulator's own errors do, and that depends on what is broken. So the search is repeated about
its own result until the set stays the same; then the finalists are judged, each about itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.base import DamageDiagnosis, Estimation, HypothesisCost, Round
from estexp_jax.recovery.estimation.edits import Place
from estexp_jax.recovery.estimation.error_model import TEMPER
from estexp_jax.recovery.estimation.genome import Items
from estexp_jax.recovery.estimation.options import DamageOptions, damage_options
from estexp_jax.recovery.simulator import DamageSimulator
from estexp_jax.search import set_search
from estexp_jax.search.set_moves import Items as Indexed
from estexp_jax.search.set_moves import pruned
from estexp_jax.search.set_search import SetSearch

_PRICE, _PRICE_OF_TRIAL = 40.0, 20.0
"""Cost of one more change, at least, and for each trial: errors of the simulator that its ensemble misses are alike in
all samples of a trial."""
_SEARCHES, _KEPT, _FINALISTS, _LAST = 3, 12, 8, 6
_REFINED, _STEPS, _MOVES = 3, (0.15, 0.05, 0.02), 3
"""Finalists that are refined; by what shares of an amount's range, and how often by each at most."""
_FEWER: dict[str, Any] = {"bases": 2, "beam": 10, "scanned": 0, "finalists": 3, "refinements": 3, "polishes": 2}
"""Settings of each search: the first ones only have to find the neighbourhood."""
_ALARM = 2.0
"""Cost of a sample above which no hypothesis of the catalogue reproduces the recordings."""
_RIVALS, _UNLIKELY = 3, 0.01
"""Rivals told at most, and the probability below which they are not."""


@final
class ReplayEstimation(Estimation):
    """See the module."""

    def __init__(self, simulator: DamageSimulator, settings: Settings, number: int) -> None:
        self._menu = damage_options(simulator.robot, settings.catalogue)
        price = _PRICE + _PRICE_OF_TRIAL * number
        self._search = SetSearch(self._menu.options, price=price, floor=0.0, costs=True, **_FEWER)

    def begin(self, seeds: Sequence[Any]) -> dict[str, Any]:
        """See `Estimation`."""
        search = set_search.begin_set_search().to_tree()
        first = {"searches": 1, "told": [np.inf, np.inf, 0], "judged": None}
        return {"search": search, "seeds": list(seeds), "about": [], **first}

    def advance(self, state: dict[str, Any], residuals: HypothesisCost) -> dict[str, Any]:
        """See `Estimation`."""
        before = set_search.SetSearchState.from_tree(state["search"])
        about = self._menu.items(_plain(state["about"]))
        if set_search.done(before):
            return self._judged(state, before, residuals)
        asked = set_search.ask_set_search(self._search, before, [_plain(seed) for seed in state["seeds"]])
        values = residuals([self._menu.items(items) for items in asked], about)
        after = set_search.tell_set_search(self._search, before, asked, values)
        least = min((f.residual for f in before.pool), default=-np.inf)
        costs, new = [f.residual for f in after.pool], int(np.sum(np.asarray(values) < least))
        state = {**state, "search": after.to_tree(), "told": [costs[0], float(np.median(costs)), new]}
        return self._again(state, after) if set_search.done(after) else state

    def done(self, state: dict[str, Any]) -> bool:
        """See `Estimation`."""
        return state["judged"] is not None

    def rounds(self) -> int | None:
        """See `Estimation`."""
        return None

    def diagnosis(self, state: dict[str, Any]) -> DamageDiagnosis:
        """See `Estimation`."""
        judged = [(self._menu.items(_plain(j["items"])), j["cost"], j["misfit"]) for j in state["judged"]]
        worth = np.array([cost for _, cost, _ in judged]) - judged[0][1]
        shares = np.exp(-worth / (2.0 * TEMPER))
        shares /= shares.sum()
        rivals = [(items, float(p)) for (items, _, _), p in zip(judged, shares, strict=True)][1:]
        told = tuple((items, p) for items, p in rivals if p >= _UNLIKELY)[:_RIVALS]
        items, _, misfit = judged[0]
        return DamageDiagnosis(items, misfit, float(shares[0]), told, misfit > _ALARM)

    def seed(self, state: dict[str, Any]) -> Any:
        """See `Estimation`."""
        return state["judged"][0]["items"]

    def summary(self, state: dict[str, Any]) -> Round:
        """See `Estimation`."""
        best, median, dominants = state["told"]
        return Round(best, median, dominants)

    def _again(self, state: dict[str, Any], found: set_search.SetSearchState) -> dict[str, Any]:
        """Search once more about the result, unless it is the same set as before."""
        best = [list(item) for item in found.pool[0].items]
        same = [i for i, _ in best] == [i for i, _ in state["about"]]
        if same or state["searches"] >= _SEARCHES:
            return state
        seeds = [[list(item) for item in f.items] for f in found.pool[:_KEPT]]
        again = {"search": set_search.begin_set_search().to_tree(), "about": best, "searches": state["searches"] + 1}
        return {**state, **again, "seeds": seeds}

    def _judged(
        self, state: dict[str, Any], found: set_search.SetSearchState, residuals: HypothesisCost
    ) -> dict[str, Any]:
        """The finalists and what is left of the best without each member, each about itself; the best then refined.

        The last few are judged by many more of the simulator's errors: a robot on three legs may tip over or not, and
        where a small ensemble holds none that does, what happened looks impossible.
        """
        first = [f.items for f in found.pool[:_FINALISTS]]
        judged = LinearisedCandidates(self._menu, self._search.price, residuals)
        for items in [*first, *pruned(first[:_REFINED])]:
            judged.worth(items)
        for items in judged.ranked()[:_REFINED]:
            judged.refine(items)
        last = LinearisedCandidates(self._menu, self._search.price, residuals, thorough=True)
        best, *others = judged.ranked()
        for items in [best, *pruned([best]), *others[: _LAST - 1]]:
            last.worth(items)
        return {**state, "judged": last.to_tree()}


@final
class LinearisedCandidates:
    """Hypotheses, the simulator's errors judged about each itself: a reference draws amounts towards its own.

    Args:
        menu: what hypotheses count.
        price: of one more change.
        residuals: what they are judged by.
        thorough: see `HypothesisCost`.
    """

    def __init__(self, menu: DamageOptions, price: float, residuals: HypothesisCost, *, thorough: bool = False) -> None:
        self._menu, self._price, self._residuals, self._thorough = menu, price, residuals, thorough
        self._known: dict[Items, tuple[Indexed, float, float]] = {}

    def worth(self, hypothesis: Indexed) -> float:
        """Cost and price of a hypothesis; lower is better."""
        items = self._menu.items(hypothesis)
        if items not in self._known:
            cost, misfit = self._residuals.alone(items, thorough=self._thorough)
            self._known[items] = (hypothesis, cost + self._price * len(items), misfit)
        return self._known[items][1]

    def ranked(self) -> list[Indexed]:
        """The best of each set of places, best first.

        Two sets of options may say the same: a leg is lost, and that its foot is lost with it.
        """
        best: dict[tuple[Place, ...], Indexed] = {}
        for items, known in sorted(self._known.items(), key=lambda entry: entry[1][1]):
            best.setdefault(tuple(place for place, _ in items), known[0])
        return list(best.values())

    def refine(self, hypothesis: Indexed) -> None:
        """Move one amount after the other, by smaller and smaller steps, as long as that helps."""
        for step in _STEPS:
            for place in range(len(hypothesis)):
                for sign in (1.0, -1.0):
                    for _ in range(_MOVES):
                        moved = self._moved(hypothesis, place, sign * step)
                        if self.worth(moved) >= self.worth(hypothesis):
                            break
                        hypothesis = moved

    def to_tree(self) -> list[dict[str, Any]]:
        """The best of each set, best first."""
        known = [self._known[self._menu.items(hypothesis)] for hypothesis in self.ranked()]
        return [{"items": [list(i) for i in items], "cost": worth, "misfit": misfit} for items, worth, misfit in known]

    def _moved(self, hypothesis: Indexed, place: int, share: float) -> Indexed:
        index, amount = hypothesis[place]
        option = self._menu.options[index]
        moved = float(np.clip(amount + share * (option.high - option.low), option.low, option.high))
        return (*hypothesis[:place], (index, round(moved, 4)), *hypothesis[place + 1 :])


def _plain(items: Any) -> Indexed:
    return tuple((int(option), float(amount)) for option, amount in items)
