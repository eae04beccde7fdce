"""Searches for the smallest set of changes that explains recordings: singles, then pairs, then triples.

A hypothesis is a set of options (an effect at a place), most of them with an amount. All single ones are tried
coarsely; the best are refined; what is left unexplained is put to every option in addition; at last members are dropped
again.
A hypothesis with residual r and k members is worth

    objective = log(r + floor) + price k,    or, where r is a cost such as chi squared,    r + price k,

lower is better: each member has to pay for itself, since spurious ones absorb errors of the simulator, and below the
floor nothing is gained. No random numbers: the same recordings give the same diagnosis.

The search is a chain of rounds, ask and tell: a round asks for residuals of some hypotheses; its state is plain data.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, final

import numpy as np

from estexp_jax.search.set_moves import Items, Option, around, grown, pruned, rounded, scanned, swapped


@final
@dataclass(frozen=True)
class SetSearch:
    """What is searched, and how.

    Attributes:
        options: all that may differ.
        price: of one more member, in log residual.
        floor: residual that counts as no error at all; of no use with costs.
        costs: whether residuals are costs, and not compared by their logarithm.
        most: members at most.
        bases: hypotheses that are grown by every option.
        kept: options that are grown alone whatever their residual: what masks others.
        beam: single hypotheses that are refined; of pairs half as many, and so on.
        scanned: refined hypotheses whose amounts are each tried at every percent; of pairs fewer.
        finalists: hypotheses that are polished.
        refinements: rounds of refining, each with steps a quarter as long as before.
        polishes: rounds of polishing.
        negligible: share of the floor; an explanation with a residual below it is only pruned any more.
    """

    options: tuple[Option, ...]
    price: float = 0.4
    floor: float = 0.002
    costs: bool = False
    most: int = 3
    bases: int = 3
    kept: tuple[int, ...] = ()
    beam: int = 24
    scanned: int = 3
    finalists: int = 4
    refinements: int = 4
    polishes: int = 4
    negligible: float = 0.01


class ScoredSet(NamedTuple):
    """A hypothesis and its residual."""

    items: Items
    residual: float


class SetSearchState(NamedTuple):
    """Between two rounds.

    `pool` holds the best found for each set of options, best objective first.
    """

    stage: str  #: coarse, refine, grow, prune, polish or done
    round: int  #: of the stage
    size: int  #: members that hypotheses have grown to
    rounds: int  #: all rounds so far
    simulated: int  #: hypotheses simulated so far
    pool: tuple[ScoredSet, ...]

    def to_tree(self) -> dict[str, Any]:
        """What a checkpoint holds."""
        pool = [{"items": [list(item) for item in f.items], "residual": f.residual} for f in self.pool]
        return {**self._asdict(), "pool": pool}

    @classmethod
    def from_tree(cls, tree: dict[str, Any]) -> SetSearchState:
        """The inverse of `to_tree`."""
        pool = tuple(ScoredSet(tuple((int(o), float(a)) for o, a in f["items"]), f["residual"]) for f in tree["pool"])
        return cls(**{**tree, "pool": pool})


_KEPT = 60
"""Hypotheses in the pool."""


def begin_set_search() -> SetSearchState:
    """The state before the first round."""
    return SetSearchState("coarse", 0, 1, 0, 0, ())


def done(state: SetSearchState) -> bool:
    """Whether the search has ended."""
    return state.stage == "done"


def set_objective(search: SetSearch, found: ScoredSet) -> float:
    """log(residual + floor), or the cost, + price per member; +inf where the simulation blew up."""
    return _error(search, found) + search.price * len(found.items)


def _error(search: SetSearch, found: ScoredSet) -> float:
    return found.residual if search.costs else float(np.log(found.residual + search.floor))


def ask_set_search(search: SetSearch, state: SetSearchState, seeds: Sequence[Items] = ()) -> list[Items]:
    """The hypotheses whose residuals the next round needs; never empty.

    Args:
        search: the settings.
        state: the round before.
        seeds: earlier diagnoses, tried in the first round.
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
    # A hypothesis that nothing can be asked of: the round still takes place, with the best one once more.
    return list(dict.fromkeys(asked)) or [state.pool[0].items]


def tell_set_search(
    search: SetSearch, state: SetSearchState, asked: Sequence[Items], residuals: Iterable[float]
) -> SetSearchState:
    """The state after a round.

    Args:
        search: the settings.
        state: the round before.
        asked: what `ask_set_search` gave.
        residuals: one each, not finite where the simulation blew up.
    """
    found = [
        ScoredSet(items, float(r) if np.isfinite(r) else np.inf) for items, r in zip(asked, residuals, strict=True)
    ]
    told = state._replace(
        pool=_best(search, [*state.pool, *found]),
        rounds=state.rounds + 1,
        simulated=state.simulated + len(found),
        round=state.round + 1,
    )
    return _next(search, told)


def _next(search: SetSearch, state: SetSearchState) -> SetSearchState:
    """Which stage follows."""
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
    """Whether there is error enough for one more member to pay for itself, and the last one did."""
    best = state.pool[0]
    left = _error(search, best) - (0.0 if search.costs else np.log(search.floor))
    paid = state.size == 1 or len(best.items) == state.size
    return bool(state.size < search.most and left > search.price and paid)


def _bases(search: SetSearch, state: SetSearchState) -> list[Items]:
    """What to grow: the best that are one member smaller, and what is always kept."""
    best = [f.items for f in state.pool if len(f.items) == state.size - 1][: search.bases]
    kept = [((index, search.options[index].coarse[0]),) for index in search.kept] if state.size == 2 else []
    return list(dict.fromkeys([*best, *kept]))


def _beam(search: SetSearch, state: SetSearchState) -> list[Items]:
    """What to refine: the best of the present size, which alone have not been refined yet."""
    return [f.items for f in state.pool if len(f.items) == state.size][: search.beam // state.size]


def _step(round_: int, first: float) -> float:
    return first / 4.0**round_


def _best(search: SetSearch, found: Iterable[ScoredSet]) -> tuple[ScoredSet, ...]:
    """The best of each set of options, by objective; ties go to the smaller set, then to the first."""
    of_set: dict[tuple[int, ...], ScoredSet] = {}
    for f in found:
        options = tuple(index for index, _ in f.items)
        if options not in of_set or f.residual < of_set[options].residual:
            of_set[options] = f
    ranked = sorted(of_set.values(), key=lambda f: (set_objective(search, f), len(f.items)))
    return tuple(ranked[:_KEPT])


def set_probabilities(search: SetSearch, state: SetSearchState, weight: float) -> np.ndarray:
    """Share of each of the pool's hypotheses, (len(pool),): exp(-weight objective), summing to 1.

    Not calibrated: residuals of neighbouring samples are not independent, so `weight` is far below their number.
    """
    values = np.array([set_objective(search, f) for f in state.pool])
    shares = np.exp(-weight * (values - values[0]))
    return shares / shares.sum()
