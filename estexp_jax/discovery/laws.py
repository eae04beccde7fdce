"""Unknown laws: when no named effect explains a mismatch, the fewest terms of a library that do, at one or two joints.

Named effects may act beside them, also some that the search among names alone never came to.
The search for named effects serves as sparse regression inside the simulation: terms are added while held-out windows
agree, and taken away again. What comes out must explain as much as any claim must, and clearly more than the best
explanation with names; else nothing is said.

Source: Brunton, Proctor and Kutz, PNAS 113 (2016): laws as the fewest terms of a library that pay.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Sequence
from dataclasses import replace

import numpy as np

from estexp_jax.discovery.fitting import Progress
from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.growing import one_more
from estexp_jax.discovery.hypotheses import Place
from estexp_jax.discovery.law_guesses import likely
from estexp_jax.discovery.law_plausibility import believed, fewest_terms, pushed
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
from estexp_jax.discovery.location import where
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.selection import Selection
from estexp_jax.discovery.shorter_windows import as_nearer
from estexp_jax.discovery.stepwise_search import select
from estexp_jax.discovery.verdict import verdict
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_JOINTS, _MOST = 2, 3
"""Joints that laws are looked for at, most claims in all."""
_PROMISE = 0.6
"""Laws beside names are looked for only if a single term brings the squared error under this share."""


def unknown_law(
    unnamed: Unnamed, replayer: Callable[[Sequence[str]], OpenLoopSimulator]
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
        starts |= likely(robot, unnamed.seen, joint, TERMS, {name for name, _ in unnamed.problem.places})
    if not starts:
        return None
    plain = [p for p in unnamed.problem.places if p[0] in beside_laws() and p[1] in joints]
    places = tuple(dict.fromkeys((*starts, *plain, *named.chosen.places)))
    kept = alternatives(robot, named)
    problem = among(unnamed.problem, replayer(simulated(kept, places)), places, starts)
    if verdict(robot, named, named.chosen.claims) == "missing_physics":
        promising = yield from _promising(unnamed, problem, joints)
        if not promising:
            return None
    found, there = yield from announced(select(problem, unnamed.parameters, _MOST))
    found = replace(found, tried=(*kept, *found.tried))
    if not believed(robot, found, named, there):
        return None
    fewest = replace(found, chosen=fewest_terms(found))
    if fewest.chosen is found.chosen or not believed(robot, fewest, named, there):
        return found, there
    return fewest, about(there, fewest.chosen.fitted)


def unknown_law_nearer(
    unnamed: Unnamed, nearer: Unnamed, replayer: Callable[[Sequence[str]], OpenLoopSimulator]
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
    law, kept = found[0].chosen, alternatives(unnamed.robot, unnamed.selection)
    usual = among(unnamed.problem, replayer(simulated(kept, law.places)), unnamed.problem.places, {})
    named = replace(unnamed.selection, tried=tuple(kept))
    taken, there = yield from announced(as_nearer(usual, named, law.fitted))
    return None if taken is named else (taken, there)


def _promising(unnamed: Unnamed, problem: Problem, joints: Sequence[str]) -> Generator[Progress, None, bool]:
    """Whether one term of a law, in the place of named forces at these joints or beside them, explains much more."""
    chosen = unnamed.selection.chosen
    forces = [p for p in chosen.places if pushed(unnamed.robot, p) in joints]
    if forces:
        before, after = yield from term_instead(unnamed, problem, forces)
        if after.held_out.sum() <= _PROMISE * before.held_out.sum():
            return True
    before, after = yield from announced(one_more(problem, unnamed.parameters, chosen.fitted))
    return after.held_out.sum() <= _PROMISE * before.held_out.sum()


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
