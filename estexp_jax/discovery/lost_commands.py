"""Commands that a logger lost: the one before or the one after, where readings tell which it was.

Half-way between them is nearest where commands move smoothly. A command that jumps was never half-way, and a servo's
torque shows at once when it jumped. Readings of training recordings may tell; in test recordings nothing is chosen.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from estexp_jax.discovery.problem import Member, Problem
from estexp_jax.estimation.missing_commands import with_other_commands
from estexp_jax.physics.window import Window

_BEFORE, _BETWEEN, _AFTER = -1, 0, 1
_CLEARLY = 0.9
"""Share of the squared error half-way under which a window's lost commands count as told."""


def commanded(problem: Problem, member: Member) -> Problem:
    """The comparison with the commands lost in each training window before or after, if one fits clearly better.

    Args:
        problem: the comparison.
        member: the robot to try them on.
    """
    windows = [int(w) for w in problem.trained if _lost(problem, problem.segments[w])]
    if not windows:
        return problem
    costs = {}
    for side in (_BEFORE, _BETWEEN, _AFTER):
        every = [np.full(r.rows, side) for r in problem.recordings]
        left = _with_commands(problem, every).residuals([member], np.array(windows))[0]
        costs[side] = np.sum(left.astype(np.float64) ** 2, axis=1)
    sides = [np.full(r.rows, _BETWEEN) for r in problem.recordings]
    for i, w in enumerate(windows):
        best = min((_BEFORE, _AFTER), key=lambda side: costs[side][i])
        if costs[best][i] < _CLEARLY * costs[_BETWEEN][i]:
            s = problem.segments[w]
            sides[s.recording][s.first : s.last + 1] = best
    return _with_commands(problem, sides)


def _lost(problem: Problem, s: Window) -> bool:
    """Whether commands of a window were lost."""
    guessed = problem.recordings[s.recording].guessed
    return guessed is not None and bool(guessed[s.first : s.last + 1].any())


def _with_commands(problem: Problem, sides: list[np.ndarray]) -> Problem:
    recordings = tuple(with_other_commands(r, side) for r, side in zip(problem.recordings, sides, strict=True))

    def retold(segments: tuple[Window, ...]) -> tuple[Window, ...]:
        return tuple(replace(s, history=s.history.with_commands(recordings[s.recording].ctrl)) for s in segments)

    cut = problem.replays.cut
    cut = cut._replace(whole=retold(cut.whole), half=retold(cut.half), fine=retold(cut.fine))
    return replace(problem, recordings=recordings, replays=replace(problem.replays, cut=cut))
