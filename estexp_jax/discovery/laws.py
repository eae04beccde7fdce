"""Unknown laws: when no named effect explains a mismatch, the fewest terms of a library that do, at one or two joints.

Named effects may act beside them, also some that the search among names alone never came to.
The search for named effects serves as sparse regression inside the simulation: terms are added while held-out windows
agree, and taken away again. What comes out must explain as much as any claim must, and clearly more than the best
explanation with names; else nothing is said.

Source: Brunton, Proctor and Kutz, PNAS 113 (2016): laws as the fewest terms of a library that pay.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar, final

import numpy as np

from estexp_jax.discovery.believing import about_joint, believed, fewest_terms, outdoes, pushed
from estexp_jax.discovery.fitting import Progress
from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.growing import Setting, judged_apart, one_more
from estexp_jax.discovery.horizon import as_nearer
from estexp_jax.discovery.hypotheses import BENT, Hypothesis, Place
from estexp_jax.discovery.likely_laws import likely
from estexp_jax.discovery.location import element, where
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.rounds import at_first
from estexp_jax.discovery.screening import keeping
from estexp_jax.discovery.searching import select
from estexp_jax.discovery.selection import Explanation, Selection, folds_of
from estexp_jax.discovery.starts import Vectors
from estexp_jax.discovery.verdict import verdict
from estexp_jax.physics import scales
from estexp_jax.physics.engines.replaying import Replayer
from estexp_jax.physics.registry import every
from estexp_jax.physics.robot import Robot

_MEMORY, _INSTEAD, _SINGLE = "unknown laws", "in place of names", "a single term"
_JOINTS, _TERMS, _MOST = 2, 8, 3
"""Joints that laws are looked for at, terms that are looked at there, most claims in all."""
_BESIDE = ("viscous_friction", "coulomb_friction", "quadratic_drag", "joint_stiffness", "cogging", "torque_offset")
"""Named effects that may act at the same joint beside a law's terms: the library need not have them again."""
_PROMISE = 0.6
"""... and they are not even looked for where no single term beside the names brings it under this share."""
_BEST = 3
"""So many named explanations, the best ones, stay alternatives, and the best one of each place."""
_T = TypeVar("_T")


@final
@dataclass(frozen=True, eq=False)
class Unnamed:
    """A mismatch that nothing named explains.

    Attributes:
        robot: the nominal robot.
        problem: the comparison, claims acting from their onset on; for laws of several terms one of which nothing is
            known yet.
        parameters: the hypothesis that only values of the model are off.
        selection: of named effects.
        seen: what the joints lack, in each training recording.
    """

    robot: Robot
    problem: Problem
    parameters: Hypothesis
    selection: Selection
    seen: Sequence[ForceResidual]


def unknown_law(
    unnamed: Unnamed, replayer: Callable[[Sequence[str]], Replayer]
) -> Generator[Progress, None, tuple[Selection, Problem] | None]:
    """The explanation by an unknown law and the comparison about it; None where there is none to believe.

    Args:
        unnamed: what is to be explained.
        replayer: gives the simulator of the effects of these names.

    Yields:
        Progress.
    """
    robot, named = unnamed.robot, unnamed.selection
    joints = suspects(robot, named, unnamed.seen)
    starts: dict[Place, Vectors] = {}
    for joint in joints:
        yield Progress("unknown laws, forces", joints.index(joint), len(joints), joint)
        starts |= likely(robot, unnamed.seen, joint, _TERMS, {name for name, _ in unnamed.problem.places})
    if not starts:
        return None
    plain = [p for p in unnamed.problem.places if p[0] in _BESIDE and p[1] in joints]
    places = tuple(dict.fromkeys((*starts, *plain, *named.chosen.places)))
    kept = _kept(robot, named)
    problem = _among(unnamed.problem, replayer(_names(kept, places)), places, starts)
    if verdict(robot, named, named.chosen.claims) == "missing_physics":
        promising = yield from _promising(unnamed, problem, joints)
        if not promising:
            return None
    found, there = yield from _told(select(problem, unnamed.parameters, _MOST))
    found = replace(found, tried=(*kept, *found.tried))
    if not believed(robot, found, named, there):
        return None
    fewest = replace(found, chosen=fewest_terms(found))
    if fewest.chosen is found.chosen or not believed(robot, fewest, named, there):
        return found, there
    return fewest, about(there, fewest.chosen.fitted)


def unknown_law_nearer(
    unnamed: Unnamed, nearer: Unnamed, replayer: Callable[[Sequence[str]], Replayer]
) -> Generator[Progress, None, tuple[Selection, Problem] | None]:
    """The unknown law that shorter windows choose, if the usual ones are predicted enough better by it.

    Args:
        unnamed: what is to be explained, in the usual windows.
        nearer: the same in shorter ones.
        replayer: gives the simulator of the effects of these names.

    Yields:
        Progress.

    Returns:
        The explanation by the usual windows and the comparison about it; None where there is none to believe.
    """
    found = yield from unknown_law(nearer, replayer)
    if found is None:
        return None
    law, kept = found[0].chosen, _kept(unnamed.robot, unnamed.selection)
    usual = _among(unnamed.problem, replayer(_names(kept, law.places)), unnamed.problem.places, {})
    named = replace(unnamed.selection, tried=tuple(kept))
    taken, there = yield from _told(as_nearer(usual, named, law.fitted))
    return None if taken is named else (taken, there)


def _promising(unnamed: Unnamed, problem: Problem, joints: Sequence[str]) -> Generator[Progress, None, bool]:
    """Whether one term of a law, in the place of named forces at these joints or beside them, explains much more."""
    chosen = unnamed.selection.chosen
    forces = [p for p in chosen.places if pushed(unnamed.robot, p) in joints]
    if forces:
        before, after = yield from _instead(unnamed, problem, forces)
        if after.held_out.sum() <= _PROMISE * before.held_out.sum():
            return True
    before, after = yield from _told(one_more(problem, unnamed.parameters, chosen.fitted))
    return after.held_out.sum() <= _PROMISE * before.held_out.sum()


def _instead(
    unnamed: Unnamed, problem: Problem, names: Collection[Place]
) -> Generator[Progress, None, tuple[Explanation, Explanation]]:
    """What is chosen, and the best explanation by one term in the place of some of its names, judged alike."""
    chosen, parameters = unnamed.selection.chosen.fitted, unnamed.parameters
    problem = replace(problem, memory=problem.memory.setdefault(_INSTEAD, {}))
    rest = [p for p in chosen.hypothesis.places if p not in names]
    without = " and ".join("@".join(filter(None, p)) for p in names)
    task, stage = keeping(problem, parameters, chosen, rest), f"without {without}"
    [base] = yield from _told(at_first(about(problem, chosen), [task], stage))
    return (yield from _told(one_more(problem, parameters, base, chosen, _TERMS)))


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
    starts = likely(robot, unnamed.seen, joint, _TERMS, {name for name, _ in unnamed.problem.places})
    if not starts:
        return None
    kept = _kept(robot, named)
    problem = _among(unnamed.problem, replayer(_names(kept, tuple(starts))), tuple(starts), starts)
    problem = replace(problem, memory=problem.memory.setdefault(_SINGLE, {}))
    names = [p for p in chosen.places if about_joint(robot, p) == joint]
    before, best = yield from _instead(unnamed, problem, names)
    kept = [before if e is chosen else e for e in kept]
    if not outdoes(best, before, len(names)):
        return None
    if len(best.places) > 1:
        bare = yield from _bare(unnamed, problem, best)
        kept, best = [*kept, best], bare if outdoes(bare, best, len(best.places)) else best
    found = replace(named, tried=(*kept, best), chosen=best)
    return (found, about(problem, best.fitted)) if verdict(robot, found, best.claims) == "missing_physics" else None


def _bare(unnamed: Unnamed, problem: Problem, best: Explanation) -> Generator[Progress, None, Explanation]:
    """A term that took the place of some names, without the others: they may have made up for what it does."""
    alone = keeping(problem, unnamed.parameters, best.fitted, best.places[-1:])
    setting = Setting(unnamed.parameters, folds_of(problem))
    [bare] = yield from _told(judged_apart(setting, about(problem, best.fitted), [alone], "the term alone"))
    return bare


def _told(steps: Generator[Progress, None, _T]) -> Generator[Progress, None, _T]:
    """A search whose stages say what it is for."""
    while True:
        try:
            stage = next(steps)
        except StopIteration as end:
            return end.value
        yield stage._replace(stage=f"{_MEMORY}: {stage.stage}")


def suspects(robot: Robot, selection: Selection, seen: Sequence[ForceResidual]) -> list[str]:
    """Joints where a law may act: where named effects remove most of the error, then those that lack most force."""
    ranked = [str(entry["name"]) for entry in where(robot, selection) if entry["kind"] == "joint"]
    forced = _forced(robot, seen)
    return [j for j in dict.fromkeys((*ranked[:1], *forced[:1], *ranked, *forced)) if j in forced][:_JOINTS]


def lacks_force(robot: Robot, seen: Sequence[ForceResidual], joint: str) -> bool:
    """Whether a joint is among the few that lack most: else no force there alone can be what is missing."""
    return joint in _forced(robot, seen)[:_JOINTS]


def _forced(robot: Robot, seen: Sequence[ForceResidual]) -> list[str]:
    """Joints that moved, those first that lack most force as a share of what matters there."""
    model = robot.model
    power = np.sum([np.square(r.force).sum(axis=0) for r in seen], axis=0)
    moved = [j for j in robot.scalar_joints if any(np.ptp(r.qvel[:, model.jnt_dofadr[j]]) > 0.0 for r in seen)]
    lacks = {j: power[model.jnt_dofadr[j]] / scales.joint_torque(robot, j) ** 2 for j in moved}
    return [robot.names("joint")[j] for j in sorted(lacks, key=lambda j: lacks[j], reverse=True)]


def _names(kept: Sequence[Explanation], places: Sequence[Place]) -> list[str]:
    """Names of all effects that must be simulated, in the registry's order."""
    names = {name for e in kept for name, _ in e.places} | {name for name, _ in places} | set(BENT)
    return [e.name for e in every() if e.name in names]


def _among(problem: Problem, simulator: Replayer, places: Sequence[Place], starts: Mapping[Place, Vectors]) -> Problem:
    """The comparison among other claims, by a simulator that knows them."""
    memory = problem.memory.setdefault(_MEMORY, {})
    replays = replace(problem.replays, replayer=simulator)
    return replace(problem, replays=replays, places=tuple(places), likely={**problem.likely, **starts}, memory=memory)


def _kept(robot: Robot, selection: Selection) -> list[Explanation]:
    """Named explanations that stay beside a law: the chosen one, the best ones, and the best one of each place."""
    ranked = sorted(selection.tried, key=lambda e: e.error)
    places: dict[tuple[str, str | None], Explanation] = {}
    for e in ranked:
        if len(e.places) == 1:
            places.setdefault(element(robot, e.places[0]), e)
    wanted = [selection.chosen, *ranked[:_BEST], *places.values()]
    return [e for e in selection.tried if any(e is w for w in wanted)]
