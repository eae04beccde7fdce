"""Choosing an explanation: effects are added as long as windows that were not fitted are predicted better."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np
from scipy import stats

from estexp_jax.discovery.fitting import Fit, Progress, Task, fit
from estexp_jax.discovery.hypotheses import Hypothesis, Place
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.screening import extended, looked_at, restarted, with_rungs, without
from estexp_jax.physics.changes import Change

NOISE = 1.2
"""An error, in deviations of noise and uncertain start states, up to which there is no mismatch."""
_WORTH = 0.85
"""An added effect must bring the held-out squared error under this share of what it was ..."""
_CHANCE = 0.05
"""... and the windows must agree on it, at this level of a signed-rank test."""
_TIE = 1.03
"""Held-out squared errors this near are no reason to prefer one explanation to another."""
_FOLDS = 3
_MOST_WINDOWS = 48
"""So many windows are fitted at most: minutes of one motion teach little more, and cost as much more."""
_PROMISING = 6
"""So many of a round's hypotheses, the best fitted ones, are judged on held-out windows."""
_PRICE = 1.1
"""Factor on the held-out squared error for each effect, when explanations are compared for their probability."""


Fold = tuple[np.ndarray, np.ndarray]
"""Windows to fit, windows held out."""


@final
@dataclass(frozen=True, eq=False)
class Explanation:
    """A fitted hypothesis and how it predicts windows that it was not fitted to.

    Attributes:
        fitted: the hypothesis with its parameters, on all training windows.
        held_out: (windows,) sums of squared residuals on the held-out windows; their total is 1 for noise.
    """

    fitted: Fit
    held_out: np.ndarray

    @property
    def places(self) -> tuple[Place, ...]:
        """What it claims."""
        return self.fitted.hypothesis.places

    @property
    def claims(self) -> tuple[Change, ...]:
        """What it claims, with values."""
        return self.fitted.hypothesis.changes(self.fitted.vector, claimed=True)

    @property
    def error(self) -> float:
        """Deviations that the held-out windows are off, 1 for noise."""
        return float(np.sqrt(self.held_out.sum()))


@final
@dataclass(frozen=True, eq=False)
class Selection:
    """All explanations that were tried, and the chosen one.

    Attributes:
        nominal: the nominal simulator, nothing fitted.
        corrected: the same without the error of its coarse step.
        parameters: values of the model refitted, nothing claimed.
        tried: those with claims, in the order tried.
        chosen: `parameters`, or the last of `tried` that was worth its price.
    """

    nominal: Explanation
    corrected: Explanation
    parameters: Explanation
    tried: tuple[Explanation, ...]
    chosen: Explanation


def windows_to_fit(problem: Problem, recordings: Sequence[int]) -> np.ndarray:
    """Indices of windows of some recordings: all, or where there are very many, evenly spread ones."""
    windows = problem.windows_of(recordings)
    return windows[:: -(-len(windows) // _MOST_WINDOWS)]


def folds_of(problem: Problem, recordings: Sequence[int]) -> list[Fold]:
    """Ways to hold windows of training recordings out, so that each is held out once: (to fit, held out).

    Whole recordings are held out where there are at least three; else stretches of time. Never single samples.
    """
    windows = windows_to_fit(problem, recordings)
    owner = np.array([problem.segments[w].recording for w in windows])
    if len(recordings) >= _FOLDS:
        part = np.array([list(recordings).index(r) % _FOLDS for r in owner])
    else:
        rank = np.array([np.sum(owner[:i] == r) / np.sum(owner == r) for i, r in enumerate(owner)])
        part = (rank * _FOLDS).astype(int)
    held = [windows[part == k] for k in np.unique(part)]
    return [(np.setdiff1d(windows, h), h) for h in held] if len(held) > 1 else [(windows, windows)]


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
    windows = np.unique(np.concatenate([held for _, held in folds]))
    start = Fit(parameters, parameters.start(), np.inf)
    tasks: list[Task] = [(parameters, [start.vector])]
    around = problem.about(start.member)
    price_there = dearer(price, _held_out(around, [[start] * len(folds)], folds)[0])
    [bent] = yield from fit(around, tasks, windows, price_there, stage="parameters")
    problem = problem.heard(bent.member).about(start.member)
    [nominal] = _held_out(replace(problem, correction=None), [[start] * len(folds)], folds)
    [corrected] = _held_out(problem, [[start] * len(folds)], folds)
    tasks = [(parameters, [bent.vector])]
    [own], problem = yield from _judged_there(problem, tasks, folds, price, "parameters only")
    tried: list[Explanation] = []
    chosen = own
    for n in range(1, most + 1):
        if chosen.error <= NOISE:
            break
        stage = f"explanations with {n} effect{'s' * (n > 1)}"
        found = yield from _grown(problem, parameters, chosen.fitted, windows, folds, dearer(price, chosen), stage)
        tried += found
        best = simplest(found)
        if not worth(best, chosen):
            break
        others = [task for e in found if e is not best for task in restarted(problem, e.fitted)]
        tasks = [*restarted(problem, best.fitted), *others]
        again, problem = yield from _judged_there(problem, tasks, folds, price, f"{stage}, finer step")
        anew: dict[tuple[Place, ...], Explanation] = {e.places: e for e in again}
        tried = [anew.get(e.places, e) for e in tried]
        chosen = simplest(again)
    while len(chosen.places) > 1:
        stage = f"{len(chosen.places)} effects without one of them"
        tasks = [without(problem, parameters, chosen.fitted, place) for place in chosen.places]
        fewer, _ = yield from _judged_there(problem, tasks, folds, price, stage)
        best = min(fewer, key=lambda e: e.error)
        if worth(chosen, best):
            break
        tried, chosen, problem = [*tried, *fewer], best, problem.about(best.fitted.member)
    return Selection(nominal, corrected, own, tuple(tried), chosen), problem


def dearer(price: float, explanation: Explanation) -> float:
    """The price of unusual values while an explanation is the best: where it leaves more than noise, less can be read.

    Else values of the model would be bent to the utmost to stand in for an effect that is not yet known.
    """
    return price * max(1.0, explanation.error**2)


def _grown(
    problem: Problem,
    parameters: Hypothesis,
    chosen: Fit,
    windows: np.ndarray,
    folds: Sequence[Fold],
    price: float,
    stage: str,
) -> Generator[Progress, None, list[Explanation]]:
    """The best explanations with one effect more."""
    tasks = [extended(problem, parameters, chosen, p) for p in problem.places if p not in chosen.hypothesis.places]
    looked = yield from looked_at(problem, tasks, windows, price, stage, _PROMISING + 2)
    fits = yield from fit(problem, [(f.hypothesis, [f.vector]) for f in looked], windows, price, stage=stage)
    promising = with_rungs(sorted(fits, key=lambda f: f.cost), _PROMISING)
    return (yield from _cross_validated(problem, promising, folds, price, stage))


def _judged_there(
    problem: Problem, tasks: Sequence[Task], folds: Sequence[Fold], price: float, stage: str
) -> Generator[Progress, None, tuple[list[Explanation], Problem]]:
    """Hypotheses fitted and judged by the comparison about the first one's fit, which is returned too.

    Of tasks with the same hypothesis the better fit counts.
    """
    windows = np.unique(np.concatenate([held for _, held in folds]))
    [first, *_] = yield from fit(problem, tasks[:1], windows, price, stage=f"{stage}, at first")
    price *= max(1.0, first.cost)
    again: list[Task] = [(first.hypothesis, [first.vector, *tasks[0][1]]), *tasks[1:]]
    there = problem.about(first.member).finer()
    fits = yield from fit(there, again, windows, price, stage=stage)
    better = {f.hypothesis: f for f in sorted(fits, key=lambda f: f.cost, reverse=True)}
    judged = yield from _cross_validated(there, list(better.values()), folds, price, stage)
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


def simplest(found: Sequence[Explanation]) -> Explanation:
    """The best on held-out windows; of near ties, the one with the fewest free parameters."""
    least = min(e.held_out.sum() for e in found)
    near = [e for e in found if e.held_out.sum() <= _TIE * least]
    return min(near, key=lambda e: (len(e.fitted.hypothesis.free), e.error))


def worth(new: Explanation, old: Explanation) -> bool:
    """Whether an explanation predicts held-out windows enough better than a simpler one to be believed."""
    return bool(new.held_out.sum() < _WORTH * old.held_out.sum() and p_value(new, old) < _CHANCE)


def p_value(new: Explanation, old: Explanation) -> float:
    """Chance of windows agreeing this well that `new` is better if it were not: signed-rank test of errors, one-sided.

    With fewer than five windows there is no such test; the sum's sign alone counts.
    """
    before, after = np.sqrt(old.held_out), np.sqrt(new.held_out)
    if len(before) < 5 or np.array_equal(before, after):
        return 0.0 if after.sum() < before.sum() else 1.0
    return float(stats.wilcoxon(before, after, alternative="greater").pvalue)


def probabilities(selection: Selection, seed: int, n: int = 2000) -> np.ndarray:
    """Share of resampled held-out windows on which each of (parameters, *tried) is best, after its price."""
    everything = [selection.parameters, *selection.tried]
    costs = np.array([e.held_out * _PRICE ** len(e.places) for e in everything])
    windows = np.random.default_rng(seed).integers(0, costs.shape[1], size=(n, costs.shape[1]))
    winners = np.argmin(costs[:, windows].sum(axis=2), axis=0)
    return np.bincount(winners, minlength=len(everything)) / n
