"""A single term of a law in the place of all that is named about a joint: one number may say what several names do.

Where a name of the catalogue says as much as the term, the name is told.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping, Sequence
from dataclasses import replace

from estexp_jax.discovery.cross_validation import judged_again
from estexp_jax.discovery.fitting import Progress, Task, fit
from estexp_jax.discovery.growing import Setting, compared
from estexp_jax.discovery.hypotheses import Place
from estexp_jax.discovery.law_guesses import likely, likely_values
from estexp_jax.discovery.law_plausibility import about_joint, outdoes
from estexp_jax.discovery.law_search import (
    TERMS,
    Unnamed,
    alternatives,
    among,
    announced,
    beside_laws,
    simulated,
    term_instead,
)
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.rounds import at_first
from estexp_jax.discovery.screening import instead, keeping
from estexp_jax.discovery.selection import Explanation, Selection, folds_of, simplest, worth
from estexp_jax.discovery.verdict import verdict
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator

_MEMORY = "a single term"


def single_term(
    unnamed: Unnamed, joint: str, replayer: Callable[[Sequence[str]], OpenLoopSimulator]
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
    plain = [(name, joint) for name in beside_laws() if (name, joint) in unnamed.problem.places]
    problem = among(unnamed.problem, replayer(simulated(kept, (*starts, *plain))), tuple(starts), starts)
    problem = replace(problem, memory=problem.memory.setdefault(_MEMORY, {}))
    names = [p for p in chosen.places if about_joint(robot, p) == joint]
    before, best = yield from term_instead(unnamed, problem, names)
    if best is before or not outdoes(best, before, len(names)):
        return None
    told = [before, best]
    if len(best.places) > 1:
        told = yield from _bare(unnamed, problem, told)
    values = likely_values(robot, unnamed.seen, joint, [name for name, _ in plain])
    told = yield from _plainest(unnamed, problem, told, values)
    others, there = [e for e in kept if e is not chosen], about(problem, told[-1].fitted)
    tried = judged_again(there, [*others, *told], folds_of(problem))
    found = replace(named, tried=tuple(tried), chosen=tried[-1])
    return (found, there) if verdict(robot, found, found.chosen.claims) == "missing_physics" else None


def _bare(
    unnamed: Unnamed, problem: Problem, told: Sequence[Explanation]
) -> Generator[Progress, None, list[Explanation]]:
    """With a term, told last, without the names beside it: they may have made up for what it does."""
    best = told[-1]
    alone = keeping(problem, unnamed.parameters, best.fitted, best.places[-1:])
    *again, bare = yield from _judged_alike(unnamed, problem, told, [alone], "the term alone")
    return [*again, bare] if outdoes(bare, again[-1], len(best.places)) else again


def _plainest(
    unnamed: Unnamed, problem: Problem, told: Sequence[Explanation], names: Mapping[Place, Vectors]
) -> Generator[Progress, None, list[Explanation]]:
    """With a term, told last, one of these names in its place, if it says as much with less: that is told last then.

    Where friction is told as larger one way than the other by nothing, or at a place as wide as all that was seen, it
    is friction: of a name with fewer numbers a term must be worth more.
    """
    best = told[-1].fitted
    tasks = [instead(problem, unnamed.parameters, best, best.hypothesis.places[-1], *name) for name in names.items()]
    if not tasks:
        return list(told)
    judged = yield from _judged_alike(unnamed, problem, told, tasks, "a name instead")
    again, plain = judged[: len(told)], judged[len(told) :]
    term = again[-1]
    fewer = [e for e in plain if len(e.fitted.hypothesis.free) < len(term.fitted.hypothesis.free)]
    spare = [e for e in fewer if not worth(term, e)]
    found = simplest(spare or [term, *plain])
    return again if found is term else [*again, found]


def _judged_alike(
    unnamed: Unnamed, problem: Problem, told: Sequence[Explanation], tasks: Sequence[Task], stage: str
) -> Generator[Progress, None, list[Explanation]]:
    """What is told so far, and more hypotheses, costed and judged by one comparison: another one has other doubts."""
    there, setting = about(problem, told[-1].fitted), Setting(unnamed.parameters, folds_of(problem))
    windows, known = there.fitted, [(e.fitted.hypothesis, [e.fitted.vector]) for e in told]
    as_told = fit(there, known, windows, there.price_of(windows), stage=f"{stage}, what is told", iterations=0)
    costed = yield from announced(as_told)
    fits = yield from announced(at_first(there, tasks, stage))
    judged, _ = yield from announced(compared(setting, there, [*costed, *fits], stage))
    return judged
