"""Searching for an explanation: effects are added while held-out windows agree, then taken away again."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from estexp_jax.discovery.cross_validation import cross_validated, held_out
from estexp_jax.discovery.fitting import Fit, Progress, Task, fit
from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.screening import extended, looked_at, simpler, without
from estexp_jax.discovery.selection import NOISE, Explanation, Fold, Selection, folds_of, simplest, worth
from estexp_jax.discovery.starts import RUNGS

_NEAR = 2.0
"""Explanations up to so many times as far off as the best are fitted on and judged about its fit."""
_PROMISING = 8
"""So many of a round's hypotheses, the most promising ones, are fitted in full."""


@final
@dataclass(frozen=True, eq=False)
class _Found:
    """Where a search has come to.

    Attributes:
        problem: the comparison about `chosen`.
        chosen: the best explanation so far.
        tried: those with claims.
    """

    problem: Problem
    chosen: Explanation
    tried: tuple[Explanation, ...]


@final
@dataclass(frozen=True, eq=False)
class _Search:
    """What does not change meanwhile: the hypothesis without claims, and the windows."""

    parameters: Hypothesis
    folds: Sequence[Fold]


def select(problem: Problem, parameters: Hypothesis, most: int) -> Generator[Progress, None, tuple[Selection, Problem]]:
    """Forward selection of up to `most` effects, then backward.

    Args:
        problem: the comparison.
        parameters: the hypothesis that only values of the model are off.
        most: largest number of effects.

    Yields:
        Progress of each round's fits.

    Returns:
        The selection, and the comparison about the chosen explanation.
    """
    search = _Search(parameters, folds_of(problem))
    start = Fit(parameters, parameters.start(), np.inf)
    tasks: list[Task] = [(parameters, [start.vector])]
    [bent], around = yield from fitted(about(problem, start), tasks, "parameters")
    problem = about(around.heard(bent.member), start)
    plain = replace(problem, rough=None)  # what the step does is no noise where the step itself is asked for
    nominal, corrected = (held_out(p, start, search.folds) for p in (replace(plain, step=None), plain))
    [own], problem = yield from _judged_about(search, problem, bent, [bent], "parameters only")
    found = _Found(problem, own, ())
    for n in range(1, most + 1):
        before = found.chosen
        if before.error <= NOISE:
            break
        found = yield from _added(search, found, n)
        if found.chosen is before:
            break
        if n == 2 and found.chosen.error > NOISE:
            found = yield from _exchanged(search, found)
    found = yield from _simplified(search, found)
    return Selection(nominal, corrected, own, found.tried, found.chosen), found.problem


def fitted(
    problem: Problem, tasks: Sequence[Task], stage: str, iterations: int = 8
) -> Generator[Progress, None, tuple[list[Fit], Problem]]:
    """Hypotheses fitted to all windows, first with the step's error as the comparison has it, then each with its own.

    Of tasks with the same hypothesis the better fit counts.

    Returns:
        The fits, and the comparison with their own corrections.
    """
    price, name = problem.price_of(problem.fitted), f"{stage}, at first"
    found = yield from fit(problem, tasks, problem.fitted, price, stage=name, iterations=iterations)
    better = {f.hypothesis: f for f in sorted(found, key=lambda f: f.cost, reverse=True)}
    kept = [f for f in found if better[f.hypothesis] is f]
    return (yield from _refitted(problem, kept, stage, iterations))


def _refitted(
    problem: Problem, fits: Sequence[Fit], stage: str, iterations: int = 8
) -> Generator[Progress, None, tuple[list[Fit], Problem]]:
    """Fits to which the comparison was about something else, fitted on, each with its own step's error."""
    there = problem.corrected([f.member for f in fits])
    prices = there.prices([f.member for f in fits])
    tasks: list[Task] = [(f.hypothesis, [f.vector]) for f in fits]
    return (yield from fit(there, tasks, there.fitted, prices, stage=stage, iterations=iterations)), there


def _added(search: _Search, found: _Found, n: int) -> Generator[Progress, None, _Found]:
    """The best explanation with one effect more, if it is worth it; it and its rivals judged afresh about its fit."""
    stage = f"explanations with {n} effect{'s' * (n > 1)}"
    grown = yield from _grown(search, found, found.chosen.fitted, stage)
    tried, best = (*found.tried, *grown), simplest(grown)
    if not worth(best, found.chosen):
        return replace(found, tried=tried)
    near = [best.fitted, *(e.fitted for e in _rivals(grown, best))]
    again, problem = yield from _judged_about(search, found.problem, best.fitted, near, f"{stage}, about the best")
    anew = {e.places: e for e in again}
    return _Found(problem, simplest(again), tuple(anew.get(e.places, e) for e in tried))


def _rivals(grown: Sequence[Explanation], best: Explanation) -> list[Explanation]:
    """Those that may yet turn out as good as the best, and the simpler relatives of it and them."""
    near = [e for e in grown if e is not best and e.error <= _NEAR * best.error]
    relatives = {(RUNGS.get(name), site) for name, site in (e.places[-1] for e in (best, *near))}
    return near + [e for e in grown if e is not best and e not in near and e.places[-1] in relatives]


def _exchanged(search: _Search, found: _Found) -> Generator[Progress, None, _Found]:
    """Another first effect beside the second, which was not known when the first one was chosen, if that is better."""
    stage, chosen = "another first effect", found.chosen
    hypothesis, [vector, *_] = without(found.problem, search.parameters, chosen.fitted, chosen.places[0])
    grown = yield from _grown(search, found, Fit(hypothesis, vector, np.inf), stage)
    new = [e for e in grown if set(e.places) != set(chosen.places)]
    if not new:
        return found
    other = simplest(new).fitted
    [best], problem = yield from _judged_about(search, found.problem, other, [other], f"{stage}, about the best")
    tried = (*found.tried, *(e for e in new if e.places != best.places), best)
    return _Found(problem, best, tried) if best.error < chosen.error else replace(found, tried=tried)


def _simplified(search: _Search, found: _Found) -> Generator[Progress, None, _Found]:
    """The simplest explanation that the chosen one is not worth more than."""
    while tasks := simpler(found.problem, search.parameters, found.chosen.fitted):
        stage = f"simpler than {found.chosen.fitted.hypothesis.label}"
        fewer = yield from _judged(search, found.problem, tasks, stage)
        best = min(fewer, key=lambda e: e.error)
        tried = (*found.tried, *fewer)
        if worth(found.chosen, best):
            return replace(found, tried=tried)
        found = _Found(about(found.problem, best.fitted), best, tried)
    return found


def _grown(search: _Search, found: _Found, base: Fit, stage: str) -> Generator[Progress, None, list[Explanation]]:
    """The best explanations with one effect more than a fit."""
    problem, hypothesis = found.problem, base.hypothesis
    if not hypothesis.places:  # values bent to stand in for an effect are no place to look for it
        base = Fit(hypothesis, hypothesis.start(), np.inf)
    places = [p for p in problem.places if p not in hypothesis.places]
    tasks = [extended(problem, search.parameters, base, p) for p in places]
    promising = yield from looked_at(problem, base, tasks, found.chosen.fitted.cost, stage, _PROMISING)
    return (yield from _judged(search, problem, promising, stage))


def _judged_about(
    search: _Search, problem: Problem, best: Fit, fits: Sequence[Fit], stage: str
) -> Generator[Progress, None, tuple[list[Explanation], Problem]]:
    """Fits taken further and judged by the comparison about one of them, which is returned too."""
    found, there = yield from _refitted(about(problem, best), fits, stage)
    yield Progress(f"{stage}, held-out windows", 0, 1)
    return cross_validated(there, found, search.folds), there


def _judged(
    search: _Search, problem: Problem, tasks: Sequence[Task], stage: str
) -> Generator[Progress, None, list[Explanation]]:
    """Hypotheses fitted, each with its own step's error taken out, and judged on held-out windows."""
    found, there = yield from fitted(problem, tasks, stage)
    yield Progress(f"{stage}, held-out windows", 0, 1)
    return cross_validated(there, found, search.folds)
