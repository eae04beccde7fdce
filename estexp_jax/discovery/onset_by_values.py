"""From when on something is missing, told by values of the model that were fitted to the beginnings alone.

Where an effect begins part-way, values fitted to what came before predict as well as noise lets them until it begins,
and worse from there on. No claim is needed for that, so it also tells when what nobody has named yet begins. The time
that makes two steady mean squares of short windows, the second one larger, likeliest is the onset.

Source: Inclan and Tiao, Journal of the American Statistical Association 89 (1994).
"""

from __future__ import annotations

from collections.abc import Generator

import numpy as np

from estexp_jax.discovery.diagnosis import Case
from estexp_jax.discovery.fitting import Progress, fit
from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.onset_date import short_windows
from estexp_jax.discovery.problem import Problem

_BEGINNING = 0.34
"""Share of a recording that the values are fitted to."""
_SPARED = 2.0
"""Deviations up to which nothing is missing there."""
_GROWS, _LEAST = 4.0, 1.5
"""Factor by which the mean square grows at an onset: the recordings' geometric mean, and the least in each."""


def parted(case: Case, problem: Problem, parameters: Hypothesis) -> Generator[Progress, None, dict[int, float]]:
    """When the mismatch begins in each training recording, s; empty where it is there from the start, or never.

    Args:
        case: what is explained.
        problem: the comparison.
        parameters: the hypothesis that only values of the model are off.

    Yields:
        Progress.
    """
    first = np.array([w for w in problem.fitted if _early(problem, w)], dtype=int)
    if {problem.segments[w].recording for w in first} != set(case.indices("train")):
        return {}
    there, price = problem.about((parameters, parameters.start())), problem.price_of(first)
    tasks = [(parameters, [parameters.start()])]
    [found] = yield from fit(there, tasks, first, price, stage="beginnings of recordings")
    if np.sum(there.residuals([found.member], first).astype(np.float64) ** 2) > _SPARED**2:
        return {}
    short = short_windows(case, problem).about(found.member)
    squares = np.sum(short.residuals([found.member], short.fitted)[0].astype(np.float64) ** 2, axis=1)
    owner = np.array([short.segments[w].recording for w in short.fitted])
    began, growth = {}, []
    for recording in np.unique(owner).tolist():
        own = np.flatnonzero(owner == recording)
        at, grows = _split(squares[own], short.recorded.samples(short.fitted[own]))
        growth.append(grows)
        s = short.segments[short.fitted[own[at]]]
        began[recording] = float(short.recordings[recording].time[s.first])
    return began if min(growth) > _LEAST and np.exp(np.mean(np.log(growth))) > _GROWS else {}


def _early(problem: Problem, window: int) -> bool:
    s = problem.segments[window]
    time = problem.recordings[s.recording].time
    return bool(time[s.last] <= time[0] + _BEGINNING * (time[-1] - time[0]))


def _split(squares: np.ndarray, samples: np.ndarray) -> tuple[int, float]:
    """The first window of the larger mean square, and the factor by which it is larger.

    Args:
        squares: (windows,) sums of squared residuals.
        samples: (windows,) how many there are of them.
    """
    total, number = np.cumsum(squares), np.cumsum(samples)
    k = np.arange(1, len(squares))
    before = total[k - 1] / number[k - 1]
    after = (total[-1] - total[k - 1]) / (number[-1] - number[k - 1])
    if not np.any(after > before):
        return 0, 1.0
    likelihood = -number[k - 1] * np.log(before) - (number[-1] - number[k - 1]) * np.log(after)
    best = int(np.argmax(np.where(after > before, likelihood, -np.inf)))
    return int(k[best]), float(after[best] / before[best])
