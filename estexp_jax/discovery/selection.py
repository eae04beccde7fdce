"""Explanations, how they are judged by windows that were not fitted, and which of them to believe."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np
from scipy import stats

from estexp_jax.discovery.hypotheses import Place
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.slopes import Fit, stretched
from estexp_jax.physics.effects.changes import Change

NOISE = 1.2
"""An error, in deviations of noise and uncertain start states, up to which there is no mismatch."""
_WORTH = 0.85
"""An added effect must bring the held-out squared error under this share of what it was ..."""
_CHANCE, _LUCK = 0.05, 0.01
"""... and the windows must agree on it, at these levels of a signed-rank test or of resampling ..."""
_PLAINLY = 0.3
"""... unless it brings it under this share: what acts only now and then, like a stop, shows in few windows."""
_TIE = 1.03
"""Held-out squared errors this near are no reason to prefer one explanation to another."""
_SAME = 1.02
"""Held-out squared errors this near tell nothing apart."""
_FOLDS = 3
FEWEST_WINDOWS = 5
"""For a signed-rank test."""
_PRICE, _MORE = 1.1, 1.03
"""Factors on the held-out squared error for each effect, or value of the model that is far off, and for each of an
effect's parameters beyond the first, when explanations are compared for their probability."""


Fold = tuple[np.ndarray, np.ndarray]
"""Windows to fit, windows held out."""


@final
@dataclass(frozen=True, eq=False)
class Explanation:
    """A fitted hypothesis and how it predicts windows that it was not fitted to.

    Attributes:
        fitted: the hypothesis with its parameters, on all training windows.
        held_out: (windows,) sums of squared residuals on the held-out windows; their total is 1 for noise.
        unusual: what values of the model that are off cost, in the same unit.
    """

    fitted: Fit
    held_out: np.ndarray
    unusual: float = 0.0

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
        seen: whether the chosen one is plain in the recordings themselves, however it predicts.
        piled: whether the chosen one is several names at one joint that together are not the whole of what is wrong.
    """

    nominal: Explanation
    corrected: Explanation
    parameters: Explanation
    tried: tuple[Explanation, ...]
    chosen: Explanation
    seen: bool = False
    piled: bool = False


def folds_of(problem: Problem) -> list[Fold]:
    """Ways to hold fitted windows out, so that each is held out once: (to fit, held out).

    Whole recordings are held out where there are at least three; else stretches of time. Never single samples.
    """
    windows = problem.fitted
    owner = np.array([problem.segments[w].recording for w in windows])
    recordings = sorted(set(owner.tolist()))
    if len(recordings) >= _FOLDS:
        part = np.array([recordings.index(r) % _FOLDS for r in owner])
    else:
        rank = np.array([np.sum(owner[:i] == r) / np.sum(owner == r) for i, r in enumerate(owner)])
        part = (rank * _FOLDS).astype(int)
    held = [windows[part == k] for k in np.unique(part)]
    return [(np.setdiff1d(windows, h), h) for h in held] if len(held) > 1 else [(windows, windows)]


def simplest(found: Sequence[Explanation]) -> Explanation:
    """The best on held-out windows; of near ties, the one with the fewest free parameters.

    Where nothing but noise is left, what values of the model that are off cost counts as well.
    """
    quiet = min(e.error for e in found) <= NOISE
    near = _near_best(found, [float(e.held_out.sum()) + quiet * e.unusual for e in found])
    return min(near, key=lambda e: (len(e.fitted.hypothesis.free), e.error))


def plainest(found: Sequence[Explanation]) -> Explanation:
    """The best on held-out windows, with what its values of the model cost; of near ties, the one that needs least.

    That is fewest effects and values far off together, and of those that need as many the one that names most of them.
    """
    best = _near_best(found, [float(e.held_out.sum()) + e.unusual for e in found])
    near = [(e, len(stretched(e.fitted))) for e in best]
    return min(near, key=lambda n: (len(n[0].places) + n[1], n[1], len(n[0].fitted.hypothesis.free), n[0].error))[0]


def _near_best(found: Sequence[Explanation], costs: Sequence[float]) -> list[Explanation]:
    return [e for e, cost in zip(found, costs, strict=True) if cost <= _TIE * min(costs)]


def steadiest(found: Sequence[Explanation], old: Explanation) -> Explanation:
    """The simplest of those that are worth it, else of all: one that wins much on few windows must not hide others."""
    return simplest([e for e in found if worth(e, old)] or found)


def tied(other: Explanation, chosen: Explanation) -> bool:
    """Whether held-out windows do not tell an explanation of no more effects from the chosen one.

    With more numbers it may be improbable for all that, as the simpler one is believed.
    """
    near = other.held_out.sum() <= _SAME * chosen.held_out.sum()
    return bool(near and 0 < len(other.places) <= len(chosen.places))


def worth(new: Explanation, old: Explanation) -> bool:
    """Whether an explanation predicts held-out windows enough better than a simpler one to be believed."""
    share = new.held_out.sum() / old.held_out.sum()
    return bool(share < _PLAINLY or (share < _WORTH and (p_value(new, old) < _CHANCE or _luck(new, old) < _LUCK)))


def _luck(new: Explanation, old: Explanation, n: int = 1000) -> float:
    """Share of resampled held-out windows on which `new` is worse: a large gain need not be one of every window."""
    gain = old.held_out - new.held_out
    windows = np.random.default_rng(0).integers(0, len(gain), size=(n, len(gain)))
    return float(np.mean(gain[windows].sum(axis=1) <= 0.0))


def p_value(new: Explanation, old: Explanation) -> float:
    """Chance of windows agreeing this well that `new` is better if it were not: signed-rank test of errors, one-sided.

    With fewer than five windows there is no such test; the sum's sign alone counts.
    """
    before, after = np.sqrt(old.held_out), np.sqrt(new.held_out)
    if len(before) < FEWEST_WINDOWS or np.array_equal(before, after):
        return 0.0 if after.sum() < before.sum() else 1.0
    test = stats.wilcoxon(before, after, alternative="greater")
    return float(test.pvalue)  # pyright: ignore[reportAttributeAccessIssue] (SciPy has no stubs)


def probabilities(selection: Selection, seed: int, n: int = 2000) -> np.ndarray:
    """Share of resampled held-out windows on which each of (parameters, *tried) is best, after its price.

    What its values of the model cost is part of that. Those that the windows can hardly tell from the best share what
    falls to it.
    """
    everything = [selection.parameters, *selection.tried]
    costs = np.array([e.held_out * _penalty(e) for e in everything])
    windows = np.random.default_rng(seed).integers(0, costs.shape[1], size=(n, costs.shape[1]))
    total = costs[:, windows].sum(axis=2) + np.array([e.unusual * _penalty(e) for e in everything])[:, None]
    wins = total <= _SAME * total.min(axis=0)
    return np.mean(wins / wins.sum(axis=0), axis=1)


def _penalty(explanation: Explanation) -> float:
    effects = len(explanation.places) + len(stretched(explanation.fitted))
    own = sum(np.isinf(f.spread) for f in explanation.fitted.hypothesis.free)
    return float(_PRICE**effects * _MORE ** max(own - len(explanation.places), 0))
