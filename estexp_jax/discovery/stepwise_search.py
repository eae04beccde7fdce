"""Searching for an explanation: effects are added while held-out windows agree, exchanged, then taken away again."""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import replace

import numpy as np

from estexp_jax.discovery.cross_validation import as_fitted
from estexp_jax.discovery.fitting import FAR, Progress, Task
from estexp_jax.discovery.growing import (
    FEW,
    Setting,
    Standing,
    alike_while_on,
    bases_of,
    believable,
    compared,
    grown_from,
    judged_apart,
)
from estexp_jax.discovery.hypotheses import Hypothesis, Place
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.rounds import fitted
from estexp_jax.discovery.screening import extended, instead, simpler, without
from estexp_jax.discovery.selection import (
    NOISE,
    Explanation,
    Selection,
    folds_of,
    plainest,
    simplest,
    steadiest,
    tied,
    worth,
)
from estexp_jax.discovery.slopes import Fit, stretched, unbent
from estexp_jax.discovery.verdict import ENOUGH, verdict
from estexp_jax.estimation.accuracy import gain
from estexp_jax.physics.effects.sites import ALL_ALIKE

_BUDGET = 800_000_000
"""More than a few effects are looked for until so many steps of a joint are simulated."""
_FITS = 0.95
"""Share of an explanation's squared error on the windows it was fitted to, to which one more effect must bring that."""
_TWINS = 3
"""So many explanations as good as the one that was made simpler are made simpler, too."""


def select(problem: Problem, parameters: Hypothesis, most: int) -> Generator[Progress, None, tuple[Selection, Problem]]:
    """Forward selection of up to `most` effects, an exchange of each of several, then backward.

    Args:
        problem: the comparison.
        parameters: the hypothesis that only values of the model are off.
        most: largest number of effects; more than a few only where these explain enough and simulating is cheap.

    Yields:
        Progress of each round's fits.

    Returns:
        The selection, and the comparison about the chosen explanation.
    """
    search = Setting(parameters, folds_of(problem))
    start = Fit(parameters, parameters.start(), np.inf)
    tasks: list[Task] = [(parameters, [start.vector])]
    [bent], around = yield from fitted(about(problem, start), tasks, "parameters")
    problem = about(around.heard(bent.member), start)
    plain = replace(problem, rough=None)  # what the step does is no noise where the step itself is asked for
    kinds = (replace(plain, step=None), plain, problem)
    nominal, mended, doubted = (as_fitted(p, [start], search.folds)[0] for p in kinds)
    corrected = doubted if doubted.error <= NOISE else mended  # but for its doubt, where nothing else is left
    [own], problem = yield from compared(search, problem, [bent], "parameters only")
    found = Standing(problem, own, ())
    if own.error <= NOISE:
        found = yield from _unbound(search, found)
    as_it_is = min(nominal, corrected, key=lambda e: e.error)
    for n in range(1, most + 1):
        before, bases = found.chosen, bases_of(found)
        if before.error <= NOISE or (n > FEW and not _goes_on(problem, before, as_it_is)):
            break
        found = yield from _added(search, found, bases, n)
        if n == 1 and found.chosen is before:
            found = yield from _added(search, found, bases, n, as_bent=True)
        if found.chosen is before:
            break
        if n == 2 and len(bases) == 1 and found.chosen.error > NOISE:
            found = yield from _exchanged(search, found, found.chosen.places[0])
    found = yield from _all_exchanged(search, found, as_it_is)
    if found.chosen.places and found.chosen.error <= NOISE:
        found = yield from _unbound(search, found)

    def said(e: Explanation) -> bool:
        judged = Selection(nominal, corrected, own, (), e)
        return verdict(problem.replayer.robot, judged, e.claims) != "unexplained"

    found = yield from _simplified(search, found, said)
    return Selection(nominal, corrected, own, found.tried, found.chosen), found.problem


def _unbound(search: Setting, found: Standing) -> Generator[Progress, None, Standing]:
    """Values that refitting bent nearly as far as they may are claimed instead, if windows are predicted no worse so.

    All values of a model together, each a little off, may stand in for one that is far off, or for all of a kind: where
    masses, motors and frictions grow by one factor most motions stay as they are, and one value that may not grow as
    far as it is off makes all others shrink.
    """
    while bent := [(f.effect, f.site) for f in stretched(found.chosen.fitted)]:
        fitted, claims = found.chosen.fitted, found.chosen.places
        alike = dict.fromkeys((name, ALL_ALIKE) for name, _ in bent)
        motors = alike_while_on(found.problem.replayer.robot, bent)
        places = [p for p in (*bent, *motors, *alike) if p in found.problem.places and p not in claims]
        if not places:
            break
        base = unbent(fitted)
        tasks = [extended(found.problem, search.parameters, base, place) for place in places]
        stage = "values that are far off" + f", beside {fitted.hypothesis.label}" * bool(claims)
        judged = yield from judged_apart(search, found.problem, tasks, stage)
        best, tried = plainest([found.chosen, *judged]), (*found.tried, *judged)
        if best is found.chosen:
            return replace(found, tried=tried)
        found = Standing(about(found.problem, best.fitted), best, tried)
    return found


def _goes_on(problem: Problem, chosen: Explanation, as_it_is: Explanation) -> bool:
    """Whether more than a few effects are looked for: not to pile up names that explain little, nor for too long."""
    work = problem.counted[0] * problem.replayer.robot.model.nv
    return gain(chosen.error, as_it_is.error, 1.0) >= ENOUGH and work < _BUDGET


def _added(
    search: Setting, found: Standing, bases: Sequence[Fit], n: int, *, as_bent: bool = False
) -> Generator[Progress, None, Standing]:
    """The best explanation with one effect more than one of some, if it is worth it.

    Values that are bent stand in for the effect, so that it is looked for from where they are as modelled. Where much
    is off by them, nothing shows from there; then it is looked for beside them, too. What does nothing to the windows
    that are fitted is not added to an effect, even if it helps held-out ones: where few windows tell an amount of the
    effect, these may be predicted anyhow.
    """
    stage, grown = f"explanations with {n} effect{'s' * (n > 1)}{', beside what is fitted' * as_bent}", list[Fit]()
    for base in bases:
        name = stage if base is bases[0] else f"{stage}, beside {base.hypothesis.label}"
        grown += yield from grown_from(search, found, base, name, as_bent=as_bent)
    best = {frozenset(f.hypothesis.places): f for f in sorted(grown, key=lambda f: f.cost, reverse=True)}
    grown = [f for f in grown if best[frozenset(f.hypothesis.places)] is f]
    if not grown:
        return found
    (before, *judged), problem = yield from compared(search, found.problem, [found.chosen.fitted, *grown], stage)
    sound = believable(judged, before)
    helping = [e for e in sound if not before.places or e.fitted.cost < _FITS * before.fitted.cost]
    tried = (*found.tried, *sound)
    if not helping:
        return replace(found, tried=tried)
    best = steadiest(helping, before) if before.places and before.error > FAR else simplest(helping)
    return Standing(problem, best, tried) if worth(best, before) else replace(found, tried=tried)


def _exchanged(search: Setting, found: Standing, place: Place) -> Generator[Progress, None, Standing]:
    """Another effect in the place of one, which was chosen when not all of the others were known, if that is better."""
    chosen, name = found.chosen, "@".join(filter(None, place))
    hypothesis, [vector, *_] = without(found.problem, search.parameters, chosen.fitted, place)
    stage = f"instead of {name}, beside {hypothesis.label}"
    grown = yield from grown_from(search, found, Fit(hypothesis, vector, np.inf), stage)
    new = [f for f in grown if set(f.hypothesis.places) != set(chosen.places)]
    if not new:
        return found
    (before, *judged), problem = yield from compared(search, found.problem, [chosen.fitted, *new], stage)
    sound = believable(judged, before)
    if not sound:
        return found
    tried, best = (*found.tried, *sound), simplest(sound)
    return Standing(problem, best, tried) if best.error < before.error else replace(found, tried=tried)


def _all_exchanged(search: Setting, found: Standing, as_it_is: Explanation) -> Generator[Progress, None, Standing]:
    """Where several effects leave much: each of them exchanged for another one, as long as that helps."""
    asked = set[frozenset[Place]]()
    while _goes_on(found.problem, found.chosen, as_it_is) and found.chosen.error > FAR:
        claims = frozenset(found.chosen.places)
        left = [p for p in found.chosen.places if claims - {p} not in asked]
        if len(claims) < FEW or not left:
            break
        asked.add(claims - {left[0]})
        found = yield from _exchanged(search, found, left[0])
    return found


def _simplified(
    search: Setting, found: Standing, said: Callable[[Explanation], bool]
) -> Generator[Progress, None, Standing]:
    """The simplest explanation that neither the chosen one nor any on the way to it is worth more than.

    Of several small steps each may seem to cost nothing; together they must not cost what one would not be let, nor the
    last bit that makes it an explanation at all. Nor is it simpler to bend a value of the model far, where nothing but
    noise is left, than to claim it.

    Args:
        search: what does not change.
        found: the comparison, and the best explanation.
        said: whether an explanation removes enough to be called one.
    """
    richer = [found.chosen]
    while tasks := simpler(found.problem, search.parameters, found.chosen.fitted):
        stage = f"simpler than {found.chosen.fitted.hypothesis.label}"
        fewer = yield from judged_apart(search, found.problem, tasks, stage)
        bent = len(stretched(found.chosen.fitted)) if found.chosen.error <= NOISE else np.inf
        best = min(fewer, key=lambda e: (len(stretched(e.fitted)) > bent, e.error))
        tried = (*found.tried, *fewer)
        lost = said(found.chosen) and not said(best)
        if lost or len(stretched(best.fitted)) > bent or any(worth(one, best) for one in richer):
            found = replace(found, tried=tried)
            break
        found = Standing(about(found.problem, best.fitted), best, tried)
        richer.append(best)
    return (yield from _twins_simplified(search, found, richer[0]))


def _twins_simplified(search: Setting, found: Standing, richest: Explanation) -> Generator[Progress, None, Standing]:
    """With the explanations that windows could not tell from the richest one, made simpler as that one was.

    With numbers that the chosen one does not need any more they would seem less probable than they are.
    """
    chosen, tasks = found.chosen, list[Task]()
    asked = [set(e.places) for e in (*found.tried, richest)]
    for twin in sorted((e for e in found.tried if tied(e, richest)), key=lambda e: e.error):
        old, new = (set(a.places) - set(b.places) for a, b in ((richest, twin), (twin, richest)))
        if len(old) != 1 or len(new) != 1 or not old <= set(chosen.places):
            continue
        [gone], [come] = old, new
        places = set(chosen.places) - old | new
        if places not in asked and len(tasks) < _TWINS:
            asked.append(places)
            values = twin.claims[twin.places.index(come)].parameters.values()
            tasks.append(instead(found.problem, search.parameters, chosen.fitted, gone, come, [list(values)]))
    if not tasks:
        return found
    stage = f"what could be instead, beside {chosen.fitted.hypothesis.label}"
    judged = yield from judged_apart(search, found.problem, tasks, stage)
    return replace(found, tried=(*found.tried, *judged))
