"""One round of a search: hypotheses with one effect more, fitted, and judged by windows that are held out."""

from __future__ import annotations

from collections.abc import Generator, Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.discovery.cross_validation import as_fitted, cross_validated
from estexp_jax.discovery.fitting import FAR, Progress, Task
from estexp_jax.discovery.hypotheses import Hypothesis, Place, told_of
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.possible import conceivable
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.rounds import at_first, fitted, refitted
from estexp_jax.discovery.screening import extended, looked_at, slot
from estexp_jax.discovery.selection import Explanation, Fold, folds_of
from estexp_jax.discovery.slopes import Fit
from estexp_jax.physics.effects.registry import effect, every
from estexp_jax.physics.effects.sites import driven_actuators
from estexp_jax.physics.model.robot import Robot

_NEAR, RIVALS = 2.0, 1.3
"""Fits up to so many times as far off as the best are fitted on about it and judged by windows that are held out; where
the best is `FAR` off, which is no matter of a step's own error, only its rivals are fitted on, nearer yet."""
_PROMISING, _LIKELIEST, _ONE_MORE = 8, 6, 3
"""So many of a round's hypotheses, the most promising ones, are fitted in full; fewer where the best explanation of a
robot of many joints is `FAR` off; and fewest where only the best of them is asked for."""
_JOINTS = 3
"""Degrees of freedom beyond which simulating a robot takes long."""
FEW = 3
"""More effects than so many are looked for only where these explain enough."""
_MOST = 0.999
"""Share of the largest value a number may have from which it is there."""
_MUCH, _BASES = 3.0, 3
"""Where the best single effect leaves more than so many deviations, up to so many of its rivals are all added to."""


@final
@dataclass(frozen=True, eq=False)
class Standing:
    """Where a search has come to.

    Attributes:
        problem: the comparison about `chosen`.
        chosen: the best explanation so far.
        tried: those with claims.
    """

    problem: Problem
    chosen: Explanation
    tried: tuple[Explanation, ...]


@final
@dataclass(frozen=True, eq=False)
class Setting:
    """What does not change meanwhile: the hypothesis without claims, and the windows."""

    parameters: Hypothesis
    folds: Sequence[Fold]


def one_more(
    problem: Problem, parameters: Hypothesis, base: Fit, rival: Fit | None = None, most: int = _ONE_MORE
) -> Generator[Progress, None, tuple[Explanation, Explanation]]:
    """A fit, and the best explanation that has one effect more, judged alike.

    Args:
        problem: the comparison, of whose step and starts nothing need be known.
        parameters: the hypothesis that only values of the model are off.
        base: the fit.
        rival: another fit, judged instead of it.
        most: so many of the most promising effects are fitted in full.
    """
    search, there, stage = Setting(parameters, folds_of(problem)), about(problem, base), "one effect more"
    found = Standing(there, as_fitted(there, [base], search.folds)[0], ())
    grown = yield from grown_from(search, found, base, stage, most)
    (before, *judged), _ = yield from compared(search, there, [rival or base, *grown], stage)
    return before, min(judged, key=lambda e: e.error, default=before)


def grown_from(
    search: Setting, found: Standing, base: Fit, stage: str, most: int = _PROMISING, *, as_bent: bool = False
) -> Generator[Progress, None, list[Fit]]:
    """The most promising hypotheses with one effect more than a fit, fitted.

    Where everything is `FAR` off and simulating the robot takes long, they are fewer, and first fits are rough.

    Args:
        search: what does not change.
        found: the comparison, and the best explanation so far.
        base: the fit.
        stage: what to call it.
        most: so many of the most promising effects are fitted in full.
        as_bent: a fit without effects keeps the values that it has bent, which may stand in for the effect that is
            looked for.
    """
    problem, hypothesis = found.problem, base.hypothesis
    far = found.chosen.fitted.cost > FAR**2 and problem.replayer.robot.model.nv > _JOINTS
    if not hypothesis.places and not as_bent:  # bent values may stand in for an effect: it shows without them
        base = Fit(hypothesis, hypothesis.start(), np.inf)
    claimed = hypothesis.places
    places = [p for p in problem.places if p not in claimed and not any(at_odds(p, c) for c in claimed)]
    if not places:
        return []
    tasks = [extended(problem, search.parameters, base, p) for p in places]
    n = min(most, _LIKELIEST) if far else most
    promising = yield from looked_at(problem, base, tasks, found.chosen.fitted.cost, stage, n)
    grown = yield from at_first(problem, promising, stage, roughly=far)
    return [f for f in grown if conceivable(problem.replayer.robot, f, problem.seen)]


def at_odds(one: Place, other: Place) -> bool:
    """Whether two claims make no sense together: two forms of one effect, or an unknown law of a motor beside a name.

    Either would take up what an effect in a slightly other form than ours leaves.
    """
    effects = effect(one[0]), effect(other[0])
    motors = one[1] == other[1] and all(e.kind == "actuator" for e in effects)
    return told_of(one) == told_of(other) or (motors and not all(e.named for e in effects))


def compared(
    search: Setting, problem: Problem, fits: Sequence[Fit], stage: str
) -> Generator[Progress, None, tuple[list[Explanation], Problem]]:
    """Fits judged, in their order, by the comparison about the best of them, which is returned too.

    Those that may yet turn out as good as the best are taken further and judged on held-out windows; the others as they
    stand, which flatters them a little.
    """
    best = min(fits, key=lambda f: f.cost)
    there, close = about(problem, best), _close(fits, best)
    going = [f for f in close if best.cost <= FAR**2 or f.cost <= RIVALS**2 * best.cost]
    moved, there = yield from refitted(there, going, stage)
    fitted_on = dict(zip(map(id, going), moved, strict=True))
    further = [fitted_on.get(id(f), f) for f in close]
    yield Progress(f"{stage}, held-out windows", 0, 1)
    judged = dict(zip(map(id, close), cross_validated(there, further, search.folds), strict=True))
    others = [f for f in fits if id(f) not in judged]
    judged |= dict(zip(map(id, others), as_fitted(there, others, search.folds), strict=True))
    return [judged[id(f)] for f in fits], there


def _close(fits: Sequence[Fit], best: Fit) -> list[Fit]:
    """Those that may yet turn out as good as the best, and the simpler relatives of it and them."""
    near = [f for f in fits if f.cost <= _NEAR**2 * best.cost]
    places = [f.hypothesis.places[-1] for f in near if f.hypothesis.places]
    relatives = {(effect(name).nested_in, site) for name, site in places}
    return near + [f for f in fits if f not in near and f.hypothesis.places and f.hypothesis.places[-1] in relatives]


def judged_apart(
    search: Setting, problem: Problem, tasks: Sequence[Task], stage: str
) -> Generator[Progress, None, list[Explanation]]:
    """Hypotheses fitted, each with its own step's error taken out, and judged on held-out windows."""
    found, there = yield from fitted(problem, tasks, stage)
    yield Progress(f"{stage}, held-out windows", 0, 1)
    return cross_validated(there, found, search.folds)


def bases_of(found: Standing) -> list[Fit]:
    """What to add an effect to: the best explanation; where a single effect leaves much, also others about as good.

    Of several things that are missing, the one that explains most alone need not be any of them.
    """
    chosen = found.chosen
    if chosen.error <= _MUCH or len(chosen.places) != 1:
        return [chosen.fitted]
    ranked = sorted((e for e in found.tried if e.error <= RIVALS * chosen.error), key=lambda e: e.error)
    slots = {slot(e.places[-1]): e.fitted for e in reversed(ranked) if len(e.places) == 1}
    others = [f for s, f in reversed(slots.items()) if s != slot(chosen.places[-1])]
    return [chosen.fitted, *others[: _BASES - 1]]


def alike_while_on(robot: Robot, joints: Sequence[Place]) -> list[Place]:
    """What motors do to joints just as some effects do there, while these motors are on."""
    driven = [(robot.names("actuator")[i], robot.joint_of_actuator(i)) for i in driven_actuators(robot)]
    named = [(a, robot.names("joint")[j]) for a, j in driven if j is not None]
    return [(e.name, a) for e in every() for a, j in named if (e.alike_while_on, j) in joints]


def believable(judged: Sequence[Explanation], before: Explanation) -> list[Explanation]:
    """Those that can be believed: where much was left, no more than a few effects, or none added `_at_its_most`.

    An effect of many numbers takes up some of what nothing explains, whatever it is, and goes astray on other motions.
    """
    far = before.error > FAR
    return [e for e in judged if not (far and len(e.places) > FEW and _at_its_most(e.fitted))]


def _at_its_most(fitted: Fit) -> bool:
    """Whether the effect that a fit claims last has several numbers, and one, no phase, is as large as it may be."""
    free = zip(fitted.hypothesis.free, fitted.vector, strict=True)
    own = [(f, v) for f, v in free if (f.effect, f.site) == fitted.hypothesis.places[-1]]
    sizes = [(f, v) for f, v in own if not f.chosen and f.parameter != "phase"]
    return len(own) > 1 and any(abs(v) >= _MOST * max(f.high, -f.low) for f, v in sizes)
