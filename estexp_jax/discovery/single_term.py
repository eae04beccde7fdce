"""A single term of a law in the place of all that is named about a joint: one number may say what several names do.

Where a name of the catalogue says as much as the term, the name is told.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import replace

from estexp_jax.discovery.believing import about_joint, outdoes
from estexp_jax.discovery.fitting import Progress
from estexp_jax.discovery.growing import Setting, judged_apart
from estexp_jax.discovery.hypotheses import Place
from estexp_jax.discovery.law_search import (
    BESIDE,
    TERMS,
    Unnamed,
    alternatives,
    among,
    announced,
    simulated,
    term_instead,
)
from estexp_jax.discovery.likely_laws import likely
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.screening import instead, keeping
from estexp_jax.discovery.selection import Explanation, Selection, folds_of, simplest
from estexp_jax.discovery.verdict import verdict
from estexp_jax.physics.engines.replaying import Replayer

_MEMORY = "a single term"


def single_term(
    unnamed: Unnamed, joint: str, replayer: Callable[[Sequence[str]], Replayer]
) -> Generator[Progress, None, tuple[Selection, Problem] | None]:
    """One term of a law in the place of all that is named about a joint, where that is to be believed: see `outdoes`.

    Yields:
        Progress.

    Returns:
        The selection with it and the comparison about it; None where the names stand.
    """
    robot, named = unnamed.robot, unnamed.selection
    chosen = named.chosen
    starts = likely(robot, unnamed.seen, joint, TERMS, {name for name, _ in unnamed.problem.places})
    if not starts:
        return None
    kept = alternatives(robot, named)
    plain = [(name, joint) for name in BESIDE if (name, joint) in unnamed.problem.places]
    problem = among(unnamed.problem, replayer(simulated(kept, (*starts, *plain))), tuple(starts), starts)
    problem = replace(problem, memory=problem.memory.setdefault(_MEMORY, {}))
    names = [p for p in chosen.places if about_joint(robot, p) == joint]
    before, best = yield from term_instead(unnamed, problem, names)
    kept = [before if e is chosen else e for e in kept]
    if best is before or not outdoes(best, before, len(names)):
        return None
    told = [best]
    if len(best.places) > 1:
        bare = yield from _bare(unnamed, problem, best)
        told += [bare] if outdoes(bare, best, len(best.places)) else []
    plainest = yield from _plainest(unnamed, problem, told[-1], plain)
    told += [plainest] if plainest is not told[-1] else []
    found, there = replace(named, tried=(*kept, *told), chosen=told[-1]), about(problem, told[-1].fitted)
    return (found, there) if verdict(robot, found, found.chosen.claims) == "missing_physics" else None


def _bare(unnamed: Unnamed, problem: Problem, best: Explanation) -> Generator[Progress, None, Explanation]:
    """A term that took the place of some names, without the others: they may have made up for what it does."""
    alone = keeping(problem, unnamed.parameters, best.fitted, best.places[-1:])
    setting = Setting(unnamed.parameters, folds_of(problem))
    [bare] = yield from announced(judged_apart(setting, about(problem, best.fitted), [alone], "the term alone"))
    return bare


def _plainest(
    unnamed: Unnamed, problem: Problem, best: Explanation, names: Sequence[Place]
) -> Generator[Progress, None, Explanation]:
    """A term that took the place of some names, or one of these names in its place that says as much with less.

    Where friction is told as larger one way than the other by nothing, it is friction.
    """
    tasks = [instead(problem, unnamed.parameters, best.fitted, best.places[-1], name, []) for name in names]
    if not tasks:
        return best
    setting = Setting(unnamed.parameters, folds_of(problem))
    judged = yield from announced(judged_apart(setting, about(problem, best.fitted), tasks, "a name instead"))
    return simplest([best, *judged])
