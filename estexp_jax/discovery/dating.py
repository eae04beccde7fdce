"""From when on a claim acts, told by short windows with and without it.

Where a claim does not act yet, it makes predictions worse; from its onset on, better. The sum over short windows of
what it costs and brings has its least where it begins: the likeliest place of a change between two known models (the
cumulative sum of log-likelihood ratios). An effect that is there from the start costs nothing at first.

Source: Page, Continuous inspection schemes, Biometrika 41 (1954).
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from estexp_jax.discovery.diagnosis import Case
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.slopes import Fit
from estexp_jax.inference.windows import cut_of

_SHORT, _SHARE_OF_ALL = 0.2, 0.005
"""Least length of a window, s; and as a share of the longest recording."""
_COST = 20.0
"""Least cost of a claim before its onset, in twice the logarithm of the likelihood, for each recording."""
_SHARE = 0.1
"""The same, as a share of what it brings after its onset."""


class Dated(NamedTuple):
    """When a claim begins in each training recording, s, and the squared error with it acting from there on."""

    began: dict[int, float]
    left: float


def short_windows(case: Case, problem: Problem) -> Problem:
    """The comparison with short windows, all of which are fitted.

    Args:
        case: what is explained.
        problem: the comparison.
    """
    longest = max(float(recording.time[-1] - recording.time[0]) for recording in problem.recordings)
    cut = cut_of(case.robots, problem.recordings, max(_SHORT, _SHARE_OF_ALL * longest))
    return replace(problem.with_windows(cut), most=sys.maxsize)


def dated(short: Problem, fits: Sequence[Fit]) -> dict[int, float]:
    """When the claims begin in each training recording, s; empty where all are there from the start, or never.

    Args:
        short: the comparison by `short_windows`.
        fits: explanations with claims; the one that an onset makes best counts.
    """
    found = [d for d in (_dated(short, fitted) for fitted in fits) if d is not None]
    return min(found, key=lambda d: d.left).began if found else {}


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
    return Dated(began, left)
