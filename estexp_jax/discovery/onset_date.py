"""From when on a claim acts, told by short windows with and without it.

Where a claim does not act yet, it makes predictions worse; from its onset on, better. The sum over short windows of
what it costs and brings has its least where it begins: the likeliest place of a change between two known models (the
cumulative sum of log-likelihood ratios). An effect that is there from the start costs nothing at first.

What was fitted to everything is too weak for what begins part-way, and dates that are off by a tenth of a second bend
everything that is fitted to them. So claim and dates then take turns, each made best for the other.

Source: Page, Continuous inspection schemes, Biometrika 41 (1954).
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from estexp_jax.discovery.diagnosis import Case
from estexp_jax.discovery.fitting import Progress, fit
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.slopes import Fit
from estexp_jax.estimation.windows import window_set_of

_SHORT, _SHARE_OF_ALL = 0.2, 0.005
"""Least length of a window, s; and as a share of the longest recording."""
_COST = 20.0
"""Least cost of a claim before its onset, in twice the logarithm of the likelihood, for each recording."""
_SHARE = 0.1
"""The same, as a share of what it brings after its onset."""
_TURNS = ((0.5, 0.25), (0.125,))
"""Steps by which dates are moved after each fit of the claim, in lengths of a short window."""

Dates = dict[int, float]
"""Index of a training recording to the onset in it, s."""


class Dated(NamedTuple):
    """When a claim begins, the squared error with it acting from there on, and its fit."""

    began: Dates
    left: float
    fitted: Fit


def short_windows(case: Case, problem: Problem) -> Problem:
    """The comparison with short windows, all of which are fitted.

    Args:
        case: what is explained.
        problem: the comparison.
    """
    cut = window_set_of(case.robots, problem.recordings, _short(problem))
    return replace(problem.with_windows(cut), most=sys.maxsize)


def _short(problem: Problem) -> float:
    """Length of a short window, s."""
    longest = max(float(recording.time[-1] - recording.time[0]) for recording in problem.recordings)
    return max(_SHORT, _SHARE_OF_ALL * longest)


def dated(short: Problem, fits: Sequence[Fit]) -> Dated | None:
    """When the claims begin in each training recording; None where all are there from the start, or never.

    Args:
        short: the comparison by `short_windows`.
        fits: explanations with claims; the one that an onset makes best counts.
    """
    found = [d for d in (_dated(short, fitted) for fitted in fits) if d is not None]
    return min(found, key=lambda d: d.left, default=None)


def sharpened(
    starting_at: Callable[[Mapping[int, float]], Problem], began: Mapping[int, float], fitted: Fit, stage: str
) -> Generator[Progress, None, Dates]:
    """Dates near given ones at which claims that begin part-way leave least, in steps shorter than a window.

    Args:
        starting_at: the comparison in which claims begin at dates.
        began: roughly when they do.
        fitted: explanation with the claims.
        stage: what to call it while it goes on.

    Yields:
        Progress.
    """
    dates, hypothesis, vector = dict(began), *fitted.member
    for turn, shares in enumerate(_TURNS):
        there = starting_at(dates).about((hypothesis, vector))
        tasks, price = [(hypothesis, [vector])], there.price_of(there.fitted)
        [best] = yield from fit(there, tasks, there.fitted, price, stage=f"{stage}, turn {turn + 1}")
        vector = best.vector
        for share in shares:
            step = share * _short(there)
            ends = {r: there.recordings[r].time[[0, -1]] for r in dates}
            shifted = [{r: float(np.clip(t + k * step, *ends[r])) for r, t in dates.items()} for k in range(-3, 4)]
            left = [_left(starting_at(moved), best) for moved in shifted]
            dates = {r: shifted[int(np.argmin([one[r] for one in left]))][r] for r in dates}
    return dates


def _left(problem: Problem, fitted: Fit) -> dict[int, float]:
    """What an explanation leaves of each training recording, in squared deviations."""
    windows = problem.trained
    there = replace(problem, most=sys.maxsize).about(fitted.member)
    squares = np.sum(there.residuals([fitted.member], windows)[0].astype(np.float64) ** 2, axis=1)
    owner = np.array([problem.segments[w].recording for w in windows])
    return {r: float(squares[owner == r].sum() / there.price_of(windows)) for r in np.unique(owner).tolist()}


def _dated(short: Problem, fitted: Fit) -> Dated | None:
    hypothesis, vector = fitted.member
    there, windows = short.about(fitted.member), short.fitted
    members = [(hypothesis, hypothesis.unclaimed(vector)), fitted.member]
    off, on = np.sum(there.residuals(members, windows).astype(np.float64) ** 2, axis=2) / there.price_of(windows)
    owner = np.array([short.segments[w].recording for w in windows])
    began, left = {}, 0.0
    for recording in np.unique(owner).tolist():
        own = np.flatnonzero(owner == recording)
        brought = np.concatenate([[0.0], np.cumsum(off[own] - on[own])])
        k = int(np.argmin(brought))
        cost, gain = -brought[k], brought[-1] - brought[k]
        if not 0 < k < len(own) or cost < max(_COST, _SHARE * gain) or gain < _COST:
            return None
        s = short.segments[windows[own[k]]]
        began[recording] = float(short.recordings[recording].time[s.first])
        left += float(off[own[:k]].sum() + on[own[k:]].sum())
    return Dated(began, left, fitted)
