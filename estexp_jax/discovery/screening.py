"""Looking at many hypotheses cheaply, so that only the promising ones are fitted in full."""

from __future__ import annotations

from collections.abc import Generator, Sequence

import numpy as np

from estexp_jax.discovery.fitting import Fit, Progress, Task, fit
from estexp_jax.discovery.hypotheses import Hypothesis, Place, claiming
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.starts import RUNGS, climbed, starts
from estexp_jax.physics.registry import effect


def extended(problem: Problem, parameters: Hypothesis, chosen: Fit, place: Place) -> Task:
    """A hypothesis with one more place, and the vectors to start it from: what is known, plus any of its own starts."""
    hypothesis = claiming(problem.replayer.robot, parameters, (*chosen.hypothesis.places, place))
    known = dict(zip(_keys(chosen.hypothesis), chosen.vector, strict=True))
    is_new = np.array([(f.effect, f.site) == place for f in hypothesis.free])
    settled = np.array([known.get(k, f.neutral) for k, f in zip(_keys(hypothesis), hypothesis.free, strict=True)])
    robot, e = problem.replayer.robot, effect(place[0])
    own = [hypothesis.with_values(place, values) for values in starts(robot, e, place[1], problem.seen)]
    return hypothesis, [np.where(is_new, start, settled) for start in [hypothesis.start(), *own]]


def without(problem: Problem, parameters: Hypothesis, chosen: Fit, place: Place) -> Task:
    """A hypothesis with one place fewer, started from what the others were; a value of the model stays bent."""
    left = [p for p in chosen.hypothesis.places if p != place]
    hypothesis = claiming(problem.replayer.robot, parameters, left)
    known = dict(zip(_keys(chosen.hypothesis), chosen.vector, strict=True))
    low, high = np.array([[f.low, f.high] for f in hypothesis.free]).T
    kept = [known.get(k, f.neutral) for k, f in zip(_keys(hypothesis), hypothesis.free, strict=True)]
    return hypothesis, [np.clip(kept, low, high)]


def simpler(problem: Problem, parameters: Hypothesis, chosen: Fit) -> list[Task]:
    """What claims less than a fit: one of several effects fewer, or the simpler relative of one."""
    places = chosen.hypothesis.places
    fewer = [without(problem, parameters, chosen, place) for place in places] if len(places) > 1 else []
    lower = []
    for i, (name, site) in enumerate(places):
        relative = (RUNGS.get(name, ""), site)
        if relative in problem.places and relative not in places:
            rest, [vector] = without(problem, parameters, chosen, places[i])
            lower.append(extended(problem, parameters, Fit(rest, vector, chosen.cost), relative))
    return fewer + lower


def restarted(problem: Problem, fitted: Fit) -> list[Task]:
    """A hypothesis to be fitted once more, from where it is; and apart from that, from all starts of its last claim.

    The others start with the model's values as nominal: without the effect these were bent to stand in for it, and
    along a valley in which all masses and motors shrink alike they would be slow to come back.
    """
    hypothesis = fitted.hypothesis
    place = hypothesis.places[-1]
    claimed = np.array([(f.effect, f.site) in hypothesis.places for f in hypothesis.free])
    is_new = np.array([(f.effect, f.site) == place for f in hypothesis.free])
    nominal = np.where(claimed, fitted.vector, hypothesis.start())
    own = starts(problem.replayer.robot, effect(place[0]), place[1], problem.seen)
    fresh = [np.where(is_new, hypothesis.with_values(place, values), nominal) for values in own]
    return [(hypothesis, [fitted.vector, nominal]), (hypothesis, fresh or [nominal])]


def _keys(hypothesis: Hypothesis) -> list[tuple[str, str, str]]:
    return [(f.effect, f.site, f.parameter) for f in hypothesis.free]


def looked_at(
    problem: Problem, tasks: Sequence[Task], windows: np.ndarray, price: float, stage: str, n: int
) -> Generator[Progress, None, list[Fit]]:
    """The most promising of many hypotheses, by looks that move only what they claim last.

    All their starts are tried on a quarter of the windows. The better half, and what is simpler than one of these, goes
    on to twice as many windows, with starts from the simpler one's solution; and so on, down to `n`.
    """
    every = 4
    looked = yield from fit(
        problem, tasks, windows[::every], price, stage=f"{stage}, first look", iterations=2, newest_only=True
    )
    while every > 1:
        every //= 2
        best = with_rungs(sorted(looked, key=lambda f: f.cost), max(n, len(looked) // 2))
        again = [(f.hypothesis, [f.vector, *_from_below(f, best)]) for f in best]
        name = f"{stage}, look at 1/{every} of the windows"
        looked = yield from fit(problem, again, windows[::every], price, stage=name, iterations=2, newest_only=True)
    return with_rungs(sorted(looked, key=lambda f: f.cost), n)


def with_rungs(ranked: Sequence[Fit], n: int) -> list[Fit]:
    """The first `n`, and the simpler relatives of those that claim a richer law, wherever they rank."""
    first = list(ranked[:n])
    wanted = {(*places[:-1], (RUNGS[places[-1][0]], places[-1][1])) for places in map(_places, first) if _rich(places)}
    return first + [f for f in ranked[n:] if _places(f) in wanted]


def _places(fitted: Fit) -> tuple[Place, ...]:
    return fitted.hypothesis.places


def _rich(places: Sequence[Place]) -> bool:
    return bool(places) and places[-1][0] in RUNGS


def _from_below(fitted: Fit, others: Sequence[Fit]) -> list[np.ndarray]:
    """Vectors to start a richer law from: the solution of the simpler one."""
    name, site = fitted.hypothesis.places[-1]
    wanted = (*fitted.hypothesis.places[:-1], (RUNGS.get(name), site))
    found = []
    for f in others:
        if _places(f) == wanted:
            simpler = f.hypothesis.changes(f.vector, claimed=True)[-1].parameters
            is_new = np.array([(g.effect, g.site) == (name, site) for g in fitted.hypothesis.free])
            for values in climbed(name, simpler):
                start = fitted.hypothesis.with_values((name, site), values)
                found.append(np.where(is_new, start, fitted.vector))
    return found
