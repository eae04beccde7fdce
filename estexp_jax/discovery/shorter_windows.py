"""Shorter windows as a guide, where long ones have too many valleys.

Where a motion hangs on hairs, such as which of two teeth of its cogging a joint comes to rest on, the error of long
windows has countless valleys, and the right explanation with values a little off is no better than wrong ones. Over a
shorter time errors grow less, and its valley is wide. What is chosen there counts if long windows, too, are predicted
better by it; or if it leaves nothing but noise in the shorter ones, and nothing is found that explains the long ones.

Source: Ribeiro et al., Automatica 121 (2020): the cost of long simulations of a nearly chaotic system is no guide to
its parameters, that of short ones is.
"""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import replace
from itertools import chain
from typing import NamedTuple

import numpy as np

from estexp_jax.discovery.cross_validation import cross_validated, judged_again
from estexp_jax.discovery.fitting import FAR, Progress
from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.replays import Member
from estexp_jax.discovery.rounds import at_first, refitted
from estexp_jax.discovery.selection import NOISE, Selection, folds_of, worth
from estexp_jax.discovery.slopes import Fit
from estexp_jax.discovery.stepwise_search import select
from estexp_jax.discovery.uncertain_starts import blinded, other_starts

SHARE = 0.2
"""Length of the shorter windows, of the usual ones."""
_LEAST = 16
"""Rows that a shorter window has at least."""
_PARTS, _FEW = 0.7, 0.1
"""Slightly other starts move the end of at least this share of the windows by this factor as much as their beginning;
where servos hold the joints it is a tenth."""
_BENT = 1.0
"""Readings so many deviations from linear in their start tell nothing: the start's error is not taken out of them."""
_HALF = 0.5
"""Least share of windows in which motions stay together, that these may tell anything."""
_BEST = 3
"""So many of the best explanations are asked."""
_WORK = 1_600_000_000
"""Steps of a joint simulated so far, from which on another search would take too long."""


class Nearer(NamedTuple):
    """What was chosen by shorter windows.

    Attributes:
        selection: with what was chosen.
        problem: the comparison about it, in shorter windows.
    """

    selection: Selection
    problem: Problem


def hangs_on_hairs(problem: Problem, selection: Selection, well: float = FAR) -> bool:
    """Whether shorter windows are worth a try: nothing explains these well, and motions that start alike part in them.

    Not where the usual windows took long already: searching again takes nearly as long.

    Args:
        problem: the comparison in the usual windows.
        selection: what was chosen by them.
        well: error, in deviations, up to which they are explained well.
    """
    rows = np.median([problem.segments[w].rows for w in problem.fitted])
    long = problem.counted[0] * problem.replayer.robot.model.nv >= _WORK
    if selection.chosen.error <= well or SHARE * rows < _LEAST or long:
        return False
    best = sorted(selection.tried, key=lambda e: e.error)[:_BEST]
    return any(np.quantile(_parting(problem, e.fitted.member), 1.0 - _FEW) > _PARTS for e in (selection.chosen, *best))


def _parting(problem: Problem, member: Member) -> np.ndarray:
    """How much more other starts move the last quarter of each fitted window (windows,) than the first one.

    Zeros where every start is known exactly, so that there are no others.
    """
    [moved] = _moved(problem, member, (1.0,))
    if not len(moved):
        return np.zeros(len(problem.fitted))
    squares, rows = np.square(moved).sum(axis=(0, 3)), [problem.segments[w].rows for w in problem.fitted]
    quarter = [(n + 3) // 4 for n in rows]
    quarters = [(m[:q].mean(), m[n - q : n].mean()) for m, n, q in zip(squares, rows, quarter, strict=True)]
    first, last = np.nan_to_num(np.sqrt(quarters)).T
    return last / np.maximum(first, np.finfo(float).tiny)


def bent(problem: Problem, member: Member) -> np.ndarray:
    """How far the readings of each fitted window (windows,) are from linear in its start, in deviations of their noise.

    That much of what a slightly other start does is not taken out of the comparison. Zeros where starts are known.
    """
    there, back = _moved(problem, member, (1.0, -1.0))
    rows = [problem.segments[w].rows for w in problem.fitted]
    squares = np.square(0.5 * (there + back)).sum(axis=0).mean(axis=2)
    far = np.sqrt([m[:n].mean() for m, n in zip(squares, rows, strict=True)])
    return np.nan_to_num(far, nan=np.inf)  # what cannot be simulated


def _moved(problem: Problem, member: Member, ways: Sequence[float]) -> list[np.ndarray]:
    """What starts so many deviations off do to the readings of fitted windows, in deviations of their noise.

    Args:
        problem: the comparison.
        member: what is simulated.
        ways: deviations.

    Returns:
        For each way (starts, windows, rows, readings); no starts where all are known exactly.
    """
    windows, robot = problem.fitted, problem.replayer.robot
    own = blinded(robot, member[0], [problem.segments[w] for w in windows])
    copies = [other_starts(robot.model, own, way) for way in ways]
    played = [
        problem.replays.readings([member], np.arange(len(windows)), starts)[0] for starts in (own, *chain(*copies))
    ]
    usual, others = played[0], np.array(played[1:])
    moved = (others.reshape(-1, *usual.shape) - usual) / problem.recorded.deviation(windows, usual.shape[1])
    return np.split(moved, len(ways))


def select_nearer(
    shorter: Problem, problem: Problem, parameters: Hypothesis, usual: Selection, most: int
) -> Generator[Progress, None, tuple[Selection, Problem, Nearer]]:
    """The selection with what shorter windows choose, if the usual ones are predicted enough better by it.

    Args:
        shorter: the comparison in shorter windows.
        problem: the comparison in the usual ones.
        parameters: the hypothesis that only values of the model are off.
        usual: what was chosen by the usual windows.
        most: largest number of effects.

    Returns:
        The selection by the usual windows, the comparison about what is chosen, and what was chosen by shorter ones.
    """
    nearer = Nearer(*(yield from select(shorter, parameters, most)))
    return *(yield from as_nearer(problem, usual, nearer.selection.chosen.fitted)), nearer


def says_all(nearer: Selection, usual: Selection) -> bool:
    """Whether shorter windows are to be believed where the usual ones are not explained: nothing but noise is left.

    What explains usual ones roughly is not given up for nothing: it may be too weak to show in so short a time.

    Args:
        nearer: what was chosen by shorter windows.
        usual: what was chosen by the usual ones.
    """
    named = usual.chosen.places if usual.chosen.error <= FAR else ()
    return nearer.chosen.error <= NOISE and (named == () or nearer.chosen.places not in ((), named))


def shows_unparted(problem: Problem, selection: Selection) -> bool:
    """Whether what was chosen shows in windows, too, in which motions that start alike stay together.

    They must be half of all. A pendulum that starts upright falls to the one side or the other: laws that decide it
    rightly in one window were chosen of robots that lacked nothing. Values of the model fitted to that window are wrong
    in others, so that what is missing there is told by the model as it is, too.

    Args:
        problem: the comparison.
        selection: what was chosen by it.
    """
    plain = selection.parameters, selection.corrected, selection.nominal
    parted = np.max([bent(problem, e.fitted.member) for e in plain[::2]], axis=0) > _BENT
    if not parted.any() or not selection.chosen.places:
        return True
    held = np.concatenate([held for _, held in folds_of(problem)])
    together = ~parted[np.searchsorted(np.sort(problem.fitted), held)]
    *before, after = (replace(e, held_out=e.held_out[together]) for e in (*plain, selection.chosen))
    best = min(before, key=lambda e: e.held_out.sum())
    missing = best.held_out.sum() > NOISE**2 * together.mean()
    return bool(together.mean() >= _HALF and missing and worth(after, best))


def as_nearer(problem: Problem, usual: Selection, found: Fit) -> Generator[Progress, None, tuple[Selection, Problem]]:
    """The selection by the usual windows with what shorter ones chose, if they are predicted enough better by it.

    And fitted better: where motions part, held-out windows may be predicted better by chance.

    Args:
        problem: the comparison in the usual windows.
        usual: what was chosen by them.
        found: what shorter ones chose.

    Returns:
        The selection, and the comparison about what is chosen.
    """
    tasks, hanging = [(found.hypothesis, [found.vector])], replace(problem, hairs=True)
    at, stage = about(hanging, found), "as by shorter windows"
    nearer = yield from at_first(at, tasks, stage, 20)
    fits, there = yield from refitted(at, [usual.chosen.fitted, *nearer], stage, 20)
    folds = folds_of(there)
    before, better = cross_validated(there, fits, folds)
    if not worth(better, before) or better.fitted.cost >= before.fitted.cost:
        return usual, problem
    others = judged_again(there, [e for e in usual.tried if e is not usual.chosen], folds)
    return replace(usual, tried=(*others, before, better), chosen=better), about(there, better.fitted)
