"""Looking at many hypotheses cheaply, so that only the promising ones are fitted in full."""

from __future__ import annotations

from collections.abc import Generator, Sequence

import numpy as np

from estexp_jax.discovery.fitting import Progress, Task, fit
from estexp_jax.discovery.hypotheses import Hypothesis, Place, claiming, told_of
from estexp_jax.discovery.marginal import slackened
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.slopes import Fit, stretched, unbent
from estexp_jax.physics.effects.registry import effect

_MANY = 32
"""Windows of which an eighth is enough for a first look."""
_FIRST, _LATER = 2, 3
"""Of so many hypotheses one goes on after the first look, which has had only few windows, and after each later one."""
_BEST = 4
"""Of so many best hypotheses, richer relatives are looked at longer than they seem worth."""
_BENT = 2
"""So many values of the model that are bent far are claimed, whatever else seems worth more."""


def extended(problem: Problem, parameters: Hypothesis, chosen: Fit, place: Place) -> Task:
    """A hypothesis with one more place, and the vectors to start it from: what is known, plus any of its own starts."""
    hypothesis = claiming(problem.replayer.robot, parameters, (*chosen.hypothesis.places, place))
    known = dict(zip(_keys(chosen.hypothesis), chosen.vector, strict=True))
    is_new = np.array([(f.effect, f.site) == place for f in hypothesis.free])
    settled = np.array([known.get(k, f.neutral) for k, f in zip(_keys(hypothesis), hypothesis.free, strict=True)])
    robot, e = problem.replayer.robot, effect(place[0])
    begin = problem.likely.get(place) or e.initial_guesses(robot, place[1], problem.seen)
    own = [hypothesis.with_values(place, values) for values in begin]
    return hypothesis, [np.where(is_new, start, settled) for start in [hypothesis.start(), *own]]


def without(problem: Problem, parameters: Hypothesis, chosen: Fit, place: Place) -> Task:
    """A hypothesis with one place fewer, started from what the others were; a value of the model stays bent."""
    return keeping(problem, parameters, chosen, [p for p in chosen.hypothesis.places if p != place])


def keeping(problem: Problem, parameters: Hypothesis, chosen: Fit, places: Sequence[Place]) -> Task:
    """A hypothesis with some of a fit's places only, started from what these were; a value of the model stays bent."""
    hypothesis = claiming(problem.replayer.robot, parameters, places)
    known = dict(zip(_keys(chosen.hypothesis), chosen.vector, strict=True))
    low, high = hypothesis.bounds()
    kept = [known.get(k, f.neutral) for k, f in zip(_keys(hypothesis), hypothesis.free, strict=True)]
    return hypothesis, [np.clip(kept, low, high)]


def simpler(problem: Problem, parameters: Hypothesis, chosen: Fit) -> list[Task]:
    """What claims less than a fit: one of several effects fewer, or the simpler relative of one."""
    places = chosen.hypothesis.places
    fewer = [without(problem, parameters, chosen, place) for place in places] if len(places) > 1 else []
    lower = []
    for i, (name, site) in enumerate(places):
        relative = (effect(name).nested_in, site)
        if relative in problem.places and relative not in places:
            lower.append(_lowered(problem, parameters, chosen, i))
    return fewer + lower


def _lowered(problem: Problem, parameters: Hypothesis, chosen: Fit, i: int) -> Task:
    """A fit with the simpler relative of its i-th claim instead, started from where the richer one is, too."""
    name, site = chosen.hypothesis.places[i]
    known = chosen.hypothesis.changes(chosen.vector, claimed=True)[i].parameters
    richer = effect(name)
    return instead(problem, parameters, chosen, (name, site), (richer.nested_in, site), richer.to_simpler(known))


def instead(
    problem: Problem, parameters: Hypothesis, chosen: Fit, old: Place, new: Place, values: Sequence[Sequence[float]]
) -> Task:
    """A fit with another claim instead of one of its own, started from values of it, too, beside what else is known."""
    rest, [vector] = without(problem, parameters, chosen, old)
    hypothesis, vectors = extended(problem, parameters, Fit(rest, vector, chosen.cost), new)
    is_new = np.array([(f.effect, f.site) == new for f in hypothesis.free])
    own = [hypothesis.with_values(new, each) for each in values]
    return hypothesis, [*(np.where(is_new, v, vectors[0]) for v in own), *vectors]


def beside(fitted: Fit, other: Fit) -> np.ndarray:
    """The vector (n_free,) of a fit with another's values of the model."""
    known = dict(zip(_keys(other.hypothesis), other.vector, strict=True))
    free = fitted.hypothesis.free
    ordinary = np.array([np.isfinite(f.spread) for f in free], dtype=bool)
    theirs = [known.get(k, v) for k, v in zip(_keys(fitted.hypothesis), fitted.vector, strict=True)]
    low, high = fitted.hypothesis.bounds()
    return np.where(ordinary, np.clip(theirs, low, high), fitted.vector)


def _keys(hypothesis: Hypothesis) -> list[tuple[str, str, str]]:
    return [(f.effect, f.site, f.parameter) for f in hypothesis.free]


def looked_at(
    problem: Problem, base: Fit, tasks: Sequence[Task], cost: float, stage: str, n: int
) -> Generator[Progress, None, list[Task]]:
    """The most promising of many hypotheses, by looks that move only what they claim last.

    All their starts are tried on a quarter of the windows, of many on an eighth, half of these being those that are off
    most. The better half, what is simpler than one of these, and what is richer than the best, goes on to twice as many
    windows, with starts from the simpler one's solution; and so on, down to `n`. Forms of one effect take one place
    among them. All the time, everything that `base` fits is taken as fitted beside them. Beside a value of the model
    that `base` has bent far, claiming that value gains little so; the best such claims go on to the end besides.

    Args:
        problem: the comparison.
        base: the hypothesis that all of them add one place to, at the values that they start from.
        tasks: hypotheses with vectors (n_free,) to start from.
        cost: of the best explanation so far, 1 for noise.
        stage: what to call it.
        n: how many are wanted, forms of one effect counted once.

    Returns:
        The hypotheses with the vectors to fit them from.
    """
    looked, again, share = [Fit(h, vectors[0], np.inf) for h, vectors in tasks], list(tasks), _FIRST
    bent, free = [(f.effect, f.site) for f in stretched(base)], problem
    for every in (4, 2, 1) if len(problem.fitted) < _MANY else (8, 4, 2, 1):
        windows = _telling(problem, base, every)
        free = slackened(problem, base, windows, cost)
        name = f"{stage}, look at 1/{every} of the windows"
        looked = yield from fit(free, again, windows, 0.0, stage=name, iterations=2, newest_only=True)
        ranked = sorted(looked, key=lambda f: f.cost)
        left = len({slot(_last(f)) for f in looked}) // share
        best, share = _with_richer(with_rungs(ranked, max(n, left)), ranked), _LATER
        best += [f for f in ranked if f not in best and _last(f) in bent]
        again = [(f.hypothesis, [f.vector, *_from_below(f, best)]) for f in best]
    ranked = sorted(looked, key=lambda f: f.cost)
    found = with_rungs(ranked, n)
    found += [f for f in ranked if f not in found and _last(f) in bent][:_BENT]
    settled = _settled(problem, free, base, found)
    return [
        (h, [*vectors, unbent(f).vector] if _last(f) in bent else vectors)
        for f, (h, vectors) in zip(found, settled, strict=True)
    ]


def _telling(problem: Problem, base: Fit, every: int) -> np.ndarray:
    """One of so many fitted windows: half of them those that are off most, as what acts now and then shows in few."""
    if every == 1:
        return problem.fitted
    n = -(-len(problem.fitted) // every)
    left = np.sum(np.square(problem.residuals([base.member], problem.fitted)[0], dtype=np.float64), axis=1)
    worst = np.argsort(-left, kind="stable")[: n // 2]
    others = np.setdiff1d(np.arange(len(left)), worst)
    spread = others[np.linspace(0, len(others) - 1, n - len(worst)).round().astype(int)]
    return problem.fitted[np.sort(np.concatenate([worst, spread]))]


def _settled(problem: Problem, free: Problem, base: Fit, looked: Sequence[Fit]) -> list[Task]:
    """Hypotheses with vectors to fit them from: as they are, and with what else was taken as fitted."""
    if free.slack is None or not looked:
        return [(f.hypothesis, [f.vector]) for f in looked]
    residuals = problem.residuals([f.member for f in looked], problem.fitted)
    centre = [f.neutral if np.isfinite(f.spread) else v for f, v in zip(base.hypothesis.free, base.vector, strict=True)]
    found: list[Task] = []
    for f, offset in zip(looked, free.slack.offsets(residuals), strict=True):
        values = dict(zip(_keys(base.hypothesis), np.array(centre) + offset, strict=True))
        place = f.hypothesis.places[-1]
        settled = [
            v if (g.effect, g.site) == place else np.clip(values.get(k, v), g.low, g.high)
            for k, g, v in zip(_keys(f.hypothesis), f.hypothesis.free, f.vector, strict=True)
        ]
        found.append((f.hypothesis, [f.vector, np.array(settled)]))
    return found


def slot(place: Place) -> Place:
    """What forms of one effect have in common; dry friction of bristles is one of dry friction."""
    name, site = told_of(place)
    return effect(name).family or name, site


def with_rungs(ranked: Sequence[Fit], n: int) -> list[Fit]:
    """The first `n`, in all their forms, and the simpler relatives of richer laws among them, wherever they rank."""
    slots = list(dict.fromkeys(slot(_last(f)) for f in ranked))[:n]
    first = [f for f in ranked if slot(_last(f)) in slots]
    wanted = {(*places[:-1], _simpler(places[-1])) for places in map(_places, first) if _rich(places)}
    return first + [f for f in ranked if f not in first and _places(f) in wanted]


def _with_richer(kept: Sequence[Fit], ranked: Sequence[Fit]) -> list[Fit]:
    """With them, the richer relatives of the best, whose own starts may all have been far off."""
    best = {_places(f)[-1] for f in ranked[:_BEST]}
    return [*kept, *(f for f in ranked if f not in kept and _simpler(_last(f)) in best)]


def _simpler(place: Place) -> Place:
    """The simpler relative of an effect at its site; no effect where it has none."""
    return effect(place[0]).nested_in, place[1]


def _last(fitted: Fit) -> Place:
    return _places(fitted)[-1]


def _places(fitted: Fit) -> tuple[Place, ...]:
    return fitted.hypothesis.places


def _rich(places: Sequence[Place]) -> bool:
    return bool(places) and bool(effect(places[-1][0]).nested_in)


def _from_below(fitted: Fit, others: Sequence[Fit]) -> list[np.ndarray]:
    """Vectors to start a richer law from: the solution of the simpler one."""
    name, site = fitted.hypothesis.places[-1]
    wanted = (*fitted.hypothesis.places[:-1], _simpler((name, site)))
    found = []
    for f in others:
        if _places(f) == wanted:
            simpler = f.hypothesis.changes(f.vector, claimed=True)[-1].parameters
            is_new = np.array([(g.effect, g.site) == (name, site) for g in fitted.hypothesis.free])
            bounds = [(fitted.hypothesis.free[i].low, fitted.hypothesis.free[i].high) for i in np.flatnonzero(is_new)]
            for values in effect(name).from_simpler(simpler, bounds):
                start = fitted.hypothesis.with_values((name, site), values)
                found.append(np.where(is_new, start, fitted.vector))
    return found
