"""From when on a mismatch is there: recordings in which the missing force begins part-way.

The logarithm of the force's mean square over tenths of a second is split in two where the parts differ most (CUSUM).
Chance is the same difference in recordings whose half seconds were shuffled. Where it is small, the split that makes
two steady noises of different size likeliest tells when. Motions grow and fade too; so one joint must show it in all
training recordings, and the effect that is claimed must not help before.

Sources: Page, Biometrika 41 (1954); Inclan and Tiao, Journal of the American Statistical Association 89 (1994).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy import stats

from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.slopes import Fit

_BIN, _BLOCK = 0.1, 5
"""Length of time whose mean square counts as one, s; so many are shuffled together."""
_MARGIN = 0.1
"""Share of a recording at either end where no onset is looked for."""
_GROWS = np.log(2.0)
"""Growth of the squared force's logarithm that is called an onset."""
_EACH, _ALL = 0.05, 0.005
"""Chance allowed in each recording, and over all."""
_SHUFFLES = 400


class _Split(NamedTuple):
    """Where a force grows most."""

    size: float  # the difference, in its deviation
    growth: float  # of the logarithm of the square
    chance: float
    time: float  # s


def onsets(seen: Mapping[int, ForceResidual], dofs: Sequence[int], seed: int) -> dict[int, float]:
    """When the mismatch begins in each recording, s; empty where it is there from the start, or that cannot be told.

    Args:
        seen: what the nominal robot's joints lack, by the recording's index. Parameters fitted to whole recordings
            would leave traces of the mismatch before it began.
        dofs: the joints' degrees of freedom.
        seed: of the shuffling.
    """
    rng = np.random.default_rng(seed)
    found = [{i: _split(r.time, r.force[:, dof], rng) for i, r in seen.items()} for dof in dofs]
    if not found:
        return {}
    best = max(found, key=lambda splits: sum(s.size for s in splits.values()))
    chances = [s.chance for s in best.values()]
    if max(chances) > _EACH or min(s.growth for s in best.values()) < _GROWS:
        return {}
    if float(stats.combine_pvalues(chances).pvalue) > _ALL:  # pyright: ignore[reportAttributeAccessIssue] (no stubs)
        return {}
    return {i: s.time for i, s in best.items()}


def helps_before(problem: Problem, began: Mapping[int, float], explained: Fit) -> bool:
    """Whether an explanation predicts what came before the onset better than the nominal simulator does."""
    windows = [
        w
        for w, s in ((int(w), problem.segments[w]) for w in problem.fitted)
        if s.recording in began and problem.recordings[s.recording].time[s.last] <= began[s.recording]
    ]
    if not windows:
        return False
    hypothesis = explained.hypothesis
    members = [(hypothesis, hypothesis.start()), explained.member]
    nominal, changed = (np.sum(r.astype(np.float64) ** 2) for r in problem.residuals(members, np.array(windows)))
    return bool(changed < nominal)


def _split(time: np.ndarray, force: np.ndarray, rng: np.random.Generator) -> _Split:
    rows = max(1, round(_BIN / float(np.median(np.diff(time)))))
    bins = np.mean(np.square(force[: len(force) // rows * rows]).reshape(-1, rows), axis=1)
    if len(bins) < 4 * _BLOCK or not bins.any():
        return _Split(0.0, 0.0, 1.0, float(time[0]))
    level = np.log(bins + 1e-9 * bins.max())
    size, growth = _cusum(level)
    whole = level[: len(level) // _BLOCK * _BLOCK].reshape(-1, _BLOCK)
    shuffled = [_cusum(whole[rng.permutation(len(whole))].reshape(-1))[0] for _ in range(_SHUFFLES)]
    chance = (1 + sum(s >= size for s in shuffled)) / (_SHUFFLES + 1)
    return _Split(size, growth, chance, _likeliest(time, force))


def _cusum(level: np.ndarray) -> tuple[float, float]:
    """The largest growth at any split, in deviations, and in the unit of `level`."""
    n, edge = len(level), max(2, int(_MARGIN * len(level)))
    k = np.arange(edge, n - edge)
    total = np.cumsum(level)
    growth = (total[-1] - total[k - 1]) / (n - k) - total[k - 1] / k
    size = growth * np.sqrt(k * (n - k) / n) / max(float(level.std()), 1e-12)
    best = int(np.argmax(size))
    return float(size[best]), float(growth[best])


def _likeliest(time: np.ndarray, force: np.ndarray) -> float:
    """Where two variances, the second one larger, are likeliest."""
    n, total = len(force), np.cumsum(force**2)
    k = np.arange(int(0.5 * _MARGIN * n) + 1, int((1.0 - 0.5 * _MARGIN) * n))
    before, after = total[k - 1] / k + 1e-30, (total[-1] - total[k - 1]) / (n - k) + 1e-30
    likelihood = np.where(after > before, -k * np.log(before) - (n - k) * np.log(after), -np.inf)
    return float(time[k[int(np.argmax(likelihood))]])
