"""What searches for unknown laws share: what is to be explained, and the comparison among a library's terms."""

from __future__ import annotations

from collections.abc import Collection, Generator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar, final

from estexp_jax.discovery.fitting import Progress
from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.growing import one_more
from estexp_jax.discovery.hypotheses import Hypothesis, Place, model_values
from estexp_jax.discovery.location import element
from estexp_jax.discovery.marginal import about
from estexp_jax.discovery.problem import Problem
from estexp_jax.discovery.rounds import at_first
from estexp_jax.discovery.screening import keeping
from estexp_jax.discovery.selection import Explanation, Selection
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.registry import every
from estexp_jax.physics.engines.open_loop import OpenLoopSimulator
from estexp_jax.physics.model.robot import Robot

TERMS = 8
"""Terms that are looked at."""
_MEMORY, _INSTEAD = "unknown laws", "in place of names"
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


def term_instead(
    unnamed: Unnamed, problem: Problem, names: Collection[Place]
) -> Generator[Progress, None, tuple[Explanation, Explanation]]:
    """What is chosen, and the best explanation by one term in the place of some of its names, judged alike."""
    chosen, parameters = unnamed.selection.chosen.fitted, unnamed.parameters
    problem = replace(problem, memory=problem.memory.setdefault(_INSTEAD, {}))
    rest = [p for p in chosen.hypothesis.places if p not in names]
    without = " and ".join("@".join(filter(None, p)) for p in names)
    task, stage = keeping(problem, parameters, chosen, rest), f"without {without}"
    [base] = yield from announced(at_first(about(problem, chosen), [task], stage))
    return (yield from announced(one_more(problem, parameters, base, chosen, TERMS)))


def announced(steps: Generator[Progress, None, _T]) -> Generator[Progress, None, _T]:
    """A search whose stages say what it is for."""
    while True:
        try:
            stage = next(steps)
        except StopIteration as end:
            return end.value
        yield stage._replace(stage=f"{_MEMORY}: {stage.stage}")


def beside_laws() -> tuple[str, ...]:
    """Named effects that may act at the same joint beside a law's terms: the library need not have them again."""
    return tuple(e.name for e in every() if e.beside_laws)


def simulated(kept: Sequence[Explanation], places: Sequence[Place]) -> list[str]:
    """Names of all effects that must be simulated, in the registry's order."""
    names = {name for e in kept for name, _ in e.places} | {name for name, _ in places} | set(model_values())
    return [e.name for e in every() if e.name in names]


def among(
    problem: Problem, simulator: OpenLoopSimulator, places: Sequence[Place], starts: Mapping[Place, Vectors]
) -> Problem:
    """The comparison among other claims, by a simulator that knows them."""
    memory = problem.memory.setdefault(_MEMORY, {})
    replays = replace(problem.replays, replayer=simulator)
    return replace(problem, replays=replays, places=tuple(places), likely={**problem.likely, **starts}, memory=memory)


def alternatives(robot: Robot, selection: Selection) -> list[Explanation]:
    """Named explanations that stay beside a law: the chosen one, the best ones, and the best one of each place."""
    ranked = sorted(selection.tried, key=lambda e: e.error)
    places: dict[tuple[str, str | None], Explanation] = {}
    for e in ranked:
        if len(e.places) == 1:
            places.setdefault(element(robot, e.places[0]), e)
    wanted = [selection.chosen, *ranked[:_BEST], *places.values()]
    return [e for e in selection.tried if any(e is w for w in wanted)]
