"""Estimation for simulators with errors: a set search with replayed readings.

Costs depend on the influence of the simulator's errors, and this influence depends on the damage. So the search is
repeated with errors linearised about its last result until the set of sites does not change. Then each finalist is
evaluated with errors linearised about itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, final

import numpy as np

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.damage_options import DamageOptions, damage_options
from estexp_jax.recovery.estimation.damage_sites import DamageSite
from estexp_jax.recovery.estimation.error_model import TEMPERATURE
from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.recovery.estimation.hypothesis_cost import HypothesisCost
from estexp_jax.recovery.estimation.method import (
    DamageDiagnosis,
    Estimation,
    IterationSummary,
    catalogue_probability,
)
from estexp_jax.recovery.simulator import DamageSimulator
from estexp_jax.search import set_search
from estexp_jax.search.set_moves import OptionSet, pruned
from estexp_jax.search.set_search import SetSearch

_PRICE, _PRICE_OF_TRIAL = 40.0, 20.0
"""Price of one more change: a constant, and an amount for each trial, because errors of the simulator that the ensemble
lacks are correlated over all samples of a trial."""
_SEARCHES, _KEPT, _FINALISTS, _LAST = 3, 12, 8, 6
_REFINED, _STEPS, _MOVES = 3, (0.15, 0.05, 0.02), 3
"""Number of finalists that are refined; step sizes as shares of an amount's range; steps of each size at most."""
_FEWER: dict[str, Any] = {"bases": 2, "beam": 10, "scanned": 0, "finalists": 3, "refinements": 3, "polishes": 2}
"""Settings of each search, smaller than the defaults: the finalists are refined afterwards."""
_ALARM = 2.0
"""Misfit above which no hypothesis of the catalogue reproduces the recordings."""
_WEIGHT = 8.0
"""Of the misfit's logarithm: at the misfit of 1 that is expected, one in 257 that nothing of the catalogue is right."""
_MAX_ALTERNATIVES, _LEAST_PROBABILITY = 3, 0.01
"""Alternatives reported at most, and the least probability of a reported one."""


@final
class ReplayEstimation(Estimation):
    """The set search with replayed readings: see the module."""

    def __init__(self, simulator: DamageSimulator, settings: Settings, number: int) -> None:
        self._menu = damage_options(simulator.robot, settings.catalogue)
        price = _PRICE + _PRICE_OF_TRIAL * number
        self._search = SetSearch(self._menu.options, price=price, floor=0.0, costs=True, **_FEWER)

    def begin(self, seeds: Sequence[Any]) -> dict[str, Any]:
        """See `Estimation`."""
        search = set_search.begin_set_search().to_tree()
        first = {"searches": 1, "summary": [np.inf, np.inf, 0], "finalists": None}
        return {"search": search, "seeds": list(seeds), "reference": [], **first}

    def advance(self, state: dict[str, Any], residuals: HypothesisCost) -> dict[str, Any]:
        """See `Estimation`."""
        before = set_search.SetSearchState.from_tree(state["search"])
        reference = self._menu.items(_option_set(state["reference"]))
        if set_search.done(before):
            return self._score_finalists(state, before, residuals)
        asked = set_search.ask_set_search(self._search, before, [_option_set(seed) for seed in state["seeds"]])
        values = residuals([self._menu.items(items) for items in asked], reference)
        after = set_search.tell_set_search(self._search, before, asked, values)
        least = min((f.residual for f in before.pool), default=-np.inf)
        costs, new = [f.residual for f in after.pool], int(np.sum(np.asarray(values) < least))
        state = {**state, "search": after.to_tree(), "summary": [costs[0], float(np.median(costs)), new]}
        return self._search_again(state, after) if set_search.done(after) else state

    def done(self, state: dict[str, Any]) -> bool:
        """See `Estimation`."""
        return state["finalists"] is not None

    def n_iterations(self) -> int | None:
        """See `Estimation`."""
        return None

    def diagnosis(self, state: dict[str, Any]) -> DamageDiagnosis:
        """See `Estimation`."""
        scored = [(self._menu.items(_option_set(j["items"])), j["cost"], j["misfit"]) for j in state["finalists"]]
        excess = np.array([cost for _, cost, _ in scored]) - scored[0][1]
        shares = np.exp(-excess / (2.0 * TEMPERATURE))
        items, _, misfit = scored[0]
        shares *= catalogue_probability(misfit, _ALARM, _WEIGHT) / shares.sum()
        others = [(items, float(p)) for (items, _, _), p in zip(scored, shares, strict=True)][1:]
        alternatives = tuple((items, p) for items, p in others if p >= _LEAST_PROBABILITY)[:_MAX_ALTERNATIVES]
        return DamageDiagnosis(items, misfit, float(shares[0]), alternatives, misfit > _ALARM)

    def seed(self, state: dict[str, Any]) -> Any:
        """See `Estimation`."""
        return state["finalists"][0]["items"]

    def summary(self, state: dict[str, Any]) -> IterationSummary:
        """See `Estimation`."""
        best, median, dominants = state["summary"]
        return IterationSummary(best, median, dominants)

    def _search_again(self, state: dict[str, Any], found: set_search.SetSearchState) -> dict[str, Any]:
        """The state of one more search about the result, unless the set of sites is the same as before."""
        best = [list(item) for item in found.pool[0].items]
        same = [i for i, _ in best] == [i for i, _ in state["reference"]]
        if same or state["searches"] >= _SEARCHES:
            return state
        seeds = [[list(item) for item in f.items] for f in found.pool[:_KEPT]]
        again = {
            "search": set_search.begin_set_search().to_tree(),
            "reference": best,
            "searches": state["searches"] + 1,
        }
        return {**state, **again, "seeds": seeds}

    def _score_finalists(
        self, state: dict[str, Any], found: set_search.SetSearchState, residuals: HypothesisCost
    ) -> dict[str, Any]:
        """Evaluate the finalists, and the best ones without each member, each about itself; then refine the best.

        The last few are evaluated with a larger ensemble. A robot on three legs may or may not tip over, and with a
        small ensemble in which none does, the recording would seem impossible.
        """
        first = [f.items for f in found.pool[:_FINALISTS]]
        scored = LinearisedCandidates(self._menu, self._search.price, residuals)
        for items in [*first, *pruned(first[:_REFINED])]:
            scored.score(items)
        for items in scored.ranked()[:_REFINED]:
            scored.refine(items)
        last = LinearisedCandidates(self._menu, self._search.price, residuals, thorough=True)
        best, *others = scored.ranked()
        for items in [best, *pruned([best]), *others[: _LAST - 1]]:
            last.score(items)
        return {**state, "finalists": last.to_tree()}


@final
class LinearisedCandidates:
    """Hypotheses with the simulator's errors linearised about each; a common reference would bias their amounts.

    Args:
        menu: options of the robot.
        price: of one more change.
        residuals: cost of hypotheses.
        thorough: see `HypothesisCost`.
    """

    def __init__(self, menu: DamageOptions, price: float, residuals: HypothesisCost, *, thorough: bool = False) -> None:
        self._menu, self._price, self._residuals, self._thorough = menu, price, residuals, thorough
        self._known: dict[DamageHypothesis, tuple[OptionSet, float, float]] = {}

    def score(self, hypothesis: OptionSet) -> float:
        """Cost of a hypothesis with the price of its changes; lower is better."""
        items = self._menu.items(hypothesis)
        if items not in self._known:
            cost, misfit = self._residuals.evaluate(items, thorough=self._thorough)
            self._known[items] = (hypothesis, cost + self._price * len(items), misfit)
        return self._known[items][1]

    def ranked(self) -> list[OptionSet]:
        """The best hypothesis of each set of sites, best first.

        Different sets of options may be equivalent, such as a lost leg with and without its lost foot.
        """
        best: dict[tuple[DamageSite, ...], OptionSet] = {}
        for items, known in sorted(self._known.items(), key=lambda entry: entry[1][1]):
            best.setdefault(tuple(place for place, _ in items), known[0])
        return list(best.values())

    def refine(self, hypothesis: OptionSet) -> None:
        """Minimise the score over one amount after the other, by decreasing steps."""
        for step in _STEPS:
            for position in range(len(hypothesis)):
                for sign in (1.0, -1.0):
                    for _ in range(_MOVES):
                        moved = self._moved(hypothesis, position, sign * step)
                        if self.score(moved) >= self.score(hypothesis):
                            break
                        hypothesis = moved

    def to_tree(self) -> list[dict[str, Any]]:
        """The best of each set, best first, as plain data."""
        known = [self._known[self._menu.items(hypothesis)] for hypothesis in self.ranked()]
        return [
            {"items": [list(i) for i in items], "cost": excess, "misfit": misfit} for items, excess, misfit in known
        ]

    def _moved(self, hypothesis: OptionSet, position: int, share: float) -> OptionSet:
        index, amount = hypothesis[position]
        option = self._menu.options[index]
        moved = float(np.clip(amount + share * (option.high - option.low), option.low, option.high))
        return (*hypothesis[:position], (index, round(moved, 4)), *hypothesis[position + 1 :])


def _option_set(items: Any) -> OptionSet:
    return tuple((int(option), float(amount)) for option, amount in items)
