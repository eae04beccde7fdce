"""Search for the smallest set of changes that explains recordings: single changes, then pairs, then triples.

A hypothesis is a set of options (an effect at a site), most of them with an amount. All single options are tried
coarsely, and the best are refined. While an error is left, every option is added to the best hypotheses. In the end
members are removed again. A hypothesis with residual r and k members has the objective

    log(r + floor) + price k,    or, if r is a cost such as chi squared,    r + price k;

lower is better. The price keeps spurious members from absorbing errors of the simulator; residuals below the floor
count alike. There are no random numbers: the same recordings give the same diagnosis.

The search has an ask/tell interface: an iteration asks for residuals of some hypotheses. Its state is plain data.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, final

import numpy as np

from estexp_jax.search.set_moves import Option, OptionSet, around, grown, pruned, rounded, scanned, swapped


@final
@dataclass(frozen=True)
class SetSearch:
    """The options and the settings of a search.

    Attributes:
        options: candidate differences.
        price: of one more member, in units of the objective.
        floor: residual that counts as no error; unused with costs.
        costs: whether residuals are costs, which are compared directly and not by their logarithm.
        max_size: members of a hypothesis at most.
        bases: number of hypotheses that are extended by every option.
        always_grown: options that are extended alone whatever their residual, because they mask others.
        beam: number of single hypotheses that are refined; half as many pairs, and so on.
        scanned: number of refined hypotheses whose amounts are each tried at every percent; fewer pairs.
        finalists: number of hypotheses that are polished.
        refinements: iterations of refining, each with a quarter of the last step.
        polishes: iterations of polishing.
        negligible: share of the floor; a hypothesis with a residual below it is only pruned.
    """

    options: tuple[Option, ...]
    price: float = 0.4
    floor: float = 0.002
    costs: bool = False
    max_size: int = 3
    bases: int = 3
    always_grown: tuple[int, ...] = ()
    beam: int = 24
    scanned: int = 3
    finalists: int = 4
    refinements: int = 4
    polishes: int = 4
    negligible: float = 0.01


class ScoredSet(NamedTuple):
    """A hypothesis and its residual."""

    items: OptionSet
    residual: float


class SetSearchState(NamedTuple):
    """State between two iterations."""

    stage: str  #: coarse, refine, grow, prune, polish or done
    round: int  #: iterations of this stage
    size: int  #: largest number of members so far
    iterations: int  #: in total
    simulated: int  #: hypotheses simulated so far
    pool: tuple[ScoredSet, ...]  #: best amounts for each set of options, best objective first

    def to_tree(self) -> dict[str, Any]:
        """The tree of plain data that a checkpoint holds."""
        pool = [{"items": [list(item) for item in f.items], "residual": f.residual} for f in self.pool]
        return {**self._asdict(), "pool": pool}

    @classmethod
    def from_tree(cls, tree: dict[str, Any]) -> SetSearchState:
        """The inverse of `to_tree`."""
        pool = tuple(ScoredSet(tuple((int(o), float(a)) for o, a in f["items"]), f["residual"]) for f in tree["pool"])
        return cls(**{**tree, "pool": pool})


_POOL_SIZE = 60
"""Hypotheses in the pool at most."""


def begin_set_search() -> SetSearchState:
    """The state before the first iteration."""
    return SetSearchState("coarse", 0, 1, 0, 0, ())


def done(state: SetSearchState) -> bool:
    """Whether the search has ended."""
    return state.stage == "done"


def set_objective(search: SetSearch, found: ScoredSet) -> float:
    """log(residual + floor), or the cost, + price per member; +inf where the simulation diverged."""
    return _error(search, found) + search.price * len(found.items)


def _error(search: SetSearch, found: ScoredSet) -> float:
    return found.residual if search.costs else float(np.log(found.residual + search.floor))


def ask_set_search(search: SetSearch, state: SetSearchState, seeds: Sequence[OptionSet] = ()) -> list[OptionSet]:
    """The hypotheses whose residuals the next iteration needs; never empty.

    Args:
        search: the settings.
        state: after the last iteration.
        seeds: earlier diagnoses, tried in the first iteration.
    """
    match state.stage:
        case "coarse":
            asked = [(), *(tuple(sorted(seed)) for seed in seeds), *grown(search.options, ())]
        case "grow":
            asked = [larger for base in _bases(search, state) for larger in grown(search.options, base)]
        case "prune":
            asked = pruned([f.items for f in state.pool[: search.finalists]])
            asked += swapped(search.options, [f.items for f in state.pool[:2] if len(f.items) > 1])
        case "refine":
            beam = _beam(search, state)
            asked = around(search.options, beam, _step(state.round, 1 / 16)) + rounded(beam)
            if state.round == search.refinements - 1:
                asked += scanned(search.options, beam[: max(1, search.scanned // state.size)])
        case _:
            finalists = [f.items for f in state.pool[: search.finalists]]
            asked = around(search.options, finalists, _step(state.round, 0.004)) + rounded(finalists)
    # Without any neighbour the iteration still takes place, with the best hypothesis once more.
    return list(dict.fromkeys(asked)) or [state.pool[0].items]


def tell_set_search(
    search: SetSearch, state: SetSearchState, asked: Sequence[OptionSet], residuals: Iterable[float]
) -> SetSearchState:
    """The state after an iteration.

    Args:
        search: the settings.
        state: after the iteration before.
        asked: as returned by `ask_set_search`.
        residuals: one each, not finite where the simulation diverged.
    """
    found = [
        ScoredSet(items, float(r) if np.isfinite(r) else np.inf) for items, r in zip(asked, residuals, strict=True)
    ]
    reached = state._replace(
        pool=_best_of_each_set(search, [*state.pool, *found]),
        iterations=state.iterations + 1,
        simulated=state.simulated + len(found),
        round=state.round + 1,
    )
    return _next(search, reached)


def _next(search: SetSearch, state: SetSearchState) -> SetSearchState:
    """The state with its next stage."""
    solved = not search.costs and state.pool[0].residual <= search.negligible * search.floor
    if solved and (state.stage == "prune" or len(state.pool[0].items) < 2):
        return state._replace(stage="done")
    match state.stage:
        case _ if solved:
            return state._replace(stage="prune", round=0)
        case "coarse" | "grow":
            return state._replace(stage="refine", round=0)
        case "refine" if state.round < search.refinements:
            return state
        case "refine" if _worth_growing(search, state):
            return state._replace(stage="grow", round=0, size=state.size + 1)
        case "refine" if len(state.pool[0].items) > 1:
            return state._replace(stage="prune", round=0)
        case "polish" if state.round >= search.polishes:
            return state._replace(stage="done")
        case "polish":
            return state
        case _:
            return state._replace(stage="polish", round=0)


def _worth_growing(search: SetSearch, state: SetSearchState) -> bool:
    """Whether the error left exceeds the price of one more member, and the last one paid its price."""
    best = state.pool[0]
    left = _error(search, best) - (0.0 if search.costs else np.log(search.floor))
    paid = state.size == 1 or len(best.items) == state.size
    return bool(state.size < search.max_size and left > search.price and paid)


def _bases(search: SetSearch, state: SetSearchState) -> list[OptionSet]:
    """Hypotheses to extend: the best that are one member smaller, and those always extended."""
    best = [f.items for f in state.pool if len(f.items) == state.size - 1][: search.bases]
    kept = [((index, search.options[index].coarse[0]),) for index in search.always_grown] if state.size == 2 else []
    return list(dict.fromkeys([*best, *kept]))


def _beam(search: SetSearch, state: SetSearchState) -> list[OptionSet]:
    """Hypotheses to refine: the best of the present size; smaller ones are refined already."""
    return [f.items for f in state.pool if len(f.items) == state.size][: search.beam // state.size]


def _step(round_: int, first: float) -> float:
    return first / 4.0**round_


def _best_of_each_set(search: SetSearch, found: Iterable[ScoredSet]) -> tuple[ScoredSet, ...]:
    """The best of each set of options, ordered by objective; ties go to the smaller set, then to the first."""
    of_set: dict[tuple[int, ...], ScoredSet] = {}
    for f in found:
        options = tuple(index for index, _ in f.items)
        if options not in of_set or f.residual < of_set[options].residual:
            of_set[options] = f
    ranked = sorted(of_set.values(), key=lambda f: (set_objective(search, f), len(f.items)))
    return tuple(ranked[:_POOL_SIZE])


def set_probabilities(search: SetSearch, state: SetSearchState, weight: float) -> np.ndarray:
    """Probabilities (len(pool),) of the pool's hypotheses, proportional to exp(-weight objective).

    They are not calibrated. Residuals of neighbouring samples are correlated, so `weight` is far below their number.
    """
    values = np.array([set_objective(search, f) for f in state.pool])
    shares = np.exp(-weight * (values - values[0]))
    return shares / shares.sum()
