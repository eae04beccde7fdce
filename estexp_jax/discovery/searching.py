"""Searching for an explanation: effects are added while held-out windows agree, then taken away again."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from estexp_jax.discovery.fitting import Fit, Progress, Task, fit
from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.screening import extended, looked_at, restarted, simpler, with_rungs, without
from estexp_jax.discovery.selection import NOISE, Explanation, Fold, Selection, simplest, worth
from estexp_jax.discovery.starts import RUNGS

_NEAR = 2.0
"""Explanations up to so many times as far off as the best are judged again about its fit, where the step's error is
known: that hid a Stribeck peak behind plain friction."""
_PROMISING = 6
"""So many of a round's hypotheses, the best fitted ones, are judged on held-out windows."""


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
    """What does not change meanwhile: the hypothesis without claims, windows, price of values of the model."""

    parameters: Hypothesis
    folds: Sequence[Fold]
    price: float

    @property
    def windows(self) -> np.ndarray:
        """All windows that are fitted."""
        return np.unique(np.concatenate([held for _, held in self.folds]))


def select(
    problem: Problem, parameters: Hypothesis, folds: Sequence[Fold], price: float, most: int
) -> Generator[Progress, None, tuple[Selection, Problem]]:
    """Forward selection of up to `most` effects, then backward.

    Args:
        problem: the comparison.
        parameters: the hypothesis that only values of the model are off.
        folds: windows to fit, and held out.
        price: of unusual values of the model, as in `fit`.
        most: largest number of effects.

    Yields:
        Progress of each round's fits.

    Returns:
        The selection, and the comparison about the chosen explanation.
    """
    search = _Search(parameters, folds, price)
    start = Fit(parameters, parameters.start(), np.inf)
    around = problem.about(start.member)
    [first] = _held_out(around, [[start] * len(folds)], folds)
    tasks: list[Task] = [(parameters, [start.vector])]
    [bent] = yield from fit(around, tasks, search.windows, dearer(price, first), stage="parameters")
    problem = problem.heard(bent.member).about(start.member)
    [nominal] = _held_out(replace(problem, correction=None), [[start] * len(folds)], folds)
    [corrected] = _held_out(problem, [[start] * len(folds)], folds)
    [own], problem = yield from _judged_there(search, problem, [(parameters, [bent.vector])], "parameters only")
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


def _added(search: _Search, found: _Found, n: int) -> Generator[Progress, None, _Found]:
    """The best explanation with one effect more, if it is worth it; it and its rivals judged afresh about its fit."""
    stage = f"explanations with {n} effect{'s' * (n > 1)}"
    grown = yield from _grown(search, found, found.chosen.fitted, stage)
    tried, best = (*found.tried, *grown), simplest(grown)
    if not worth(best, found.chosen):
        return replace(found, tried=tried)
    rivals = _rivals(grown, best)
    others = [task for e in rivals for task in restarted(found.problem, e.fitted)]
    tasks = [*restarted(found.problem, best.fitted), *others]
    again, problem = yield from _judged_there(search, found.problem, tasks, f"{stage}, finer step")
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
    tasks = restarted(found.problem, simplest(new).fitted)
    [best], problem = yield from _judged_there(search, found.problem, tasks, f"{stage}, finer step")
    tried = (*found.tried, *(e for e in new if e.places != best.places), best)
    return _Found(problem, best, tried) if best.error < chosen.error else replace(found, tried=tried)


def _simplified(search: _Search, found: _Found) -> Generator[Progress, None, _Found]:
    """The simplest explanation that the chosen one is not worth more than."""
    while tasks := simpler(found.problem, search.parameters, found.chosen.fitted):
        stage = f"simpler than {found.chosen.fitted.hypothesis.label}"
        fewer, _ = yield from _judged_there(search, found.problem, tasks, stage)
        best = min(fewer, key=lambda e: e.error)
        tried = (*found.tried, *fewer)
        if worth(found.chosen, best):
            return replace(found, tried=tried)
        found = _Found(found.problem.about(best.fitted.member), best, tried)
    return found


def dearer(price: float, explanation: Explanation) -> float:
    """The price of unusual values while an explanation is the best: where it leaves more than noise, less can be read.

    Else values of the model would be bent to the utmost to stand in for an effect that is not yet known.
    """
    return price * max(1.0, explanation.error**2)


def _grown(search: _Search, found: _Found, base: Fit, stage: str) -> Generator[Progress, None, list[Explanation]]:
    """The best explanations with one effect more than a fit."""
    problem, price = found.problem, dearer(search.price, found.chosen)
    places = [p for p in problem.places if p not in base.hypothesis.places]
    tasks = [extended(problem, search.parameters, base, p) for p in places]
    looked = yield from looked_at(problem, tasks, search.windows, price, stage, _PROMISING + 2)
    fits = yield from fit(problem, [(f.hypothesis, [f.vector]) for f in looked], search.windows, price, stage=stage)
    promising = with_rungs(sorted(fits, key=lambda f: f.cost), _PROMISING)
    return (yield from _cross_validated(problem, promising, search.folds, price, stage))


def _judged_there(
    search: _Search, problem: Problem, tasks: Sequence[Task], stage: str
) -> Generator[Progress, None, tuple[list[Explanation], Problem]]:
    """Hypotheses fitted and judged by the comparison about the first one's fit, which is returned too.

    Of tasks with the same hypothesis the better fit counts.
    """
    price, windows = search.price, search.windows
    [first, *_] = yield from fit(problem, tasks[:1], windows, price, stage=f"{stage}, at first")
    price *= max(1.0, first.cost)
    again: list[Task] = [(first.hypothesis, [first.vector, *tasks[0][1]]), *tasks[1:]]
    there = problem.about(first.member).finer()
    fits = yield from fit(there, again, windows, price, stage=stage)
    better = {f.hypothesis: f for f in sorted(fits, key=lambda f: f.cost, reverse=True)}
    judged = yield from _cross_validated(there, list(better.values()), search.folds, price, stage)
    return judged, problem.about(better[first.hypothesis].member)


def _cross_validated(
    problem: Problem, fits: Sequence[Fit], folds: Sequence[Fold], price: float, stage: str
) -> Generator[Progress, None, list[Explanation]]:
    """Each hypothesis fitted anew without each fold's held-out windows, and judged on them."""
    by_fold = []
    for k, (fitted, _) in enumerate(folds):
        name = f"{stage}, held-out part {k + 1} of {len(folds)}"
        tasks: list[Task] = [(f.hypothesis, [f.vector]) for f in fits]
        by_fold.append((yield from fit(problem, tasks, fitted, price, stage=name, iterations=3)))
    found = _held_out(problem, [list(each) for each in zip(*by_fold, strict=True)], folds)
    return [replace(e, fitted=f) for e, f in zip(found, fits, strict=True)]


def _held_out(problem: Problem, fits: Sequence[Sequence[Fit]], folds: Sequence[Fold]) -> list[Explanation]:
    """Explanations of hypotheses with one fit a fold, each judged on its fold's held-out windows."""
    parts = []
    for k, (_, held) in enumerate(folds):
        residuals = problem.residuals([each[k].member for each in fits], held).astype(np.float64)
        parts.append(np.sum(residuals**2, axis=2) / len(folds))
    return [Explanation(each[0], np.concatenate([p[i] for p in parts])) for i, each in enumerate(fits)]
