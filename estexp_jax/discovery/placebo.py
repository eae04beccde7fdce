"""The placebo: what wrong effects with as many free parameters would have achieved.

Any added parameter fits recordings better. How much of an explanation's success is that, and how much is its being
right? The placebo answers: for each effect that is claimed, the best effect tried that is another one, with as many
parameters, fitted to the same windows with the same values of the model beside it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.discovery.fitting import Task
from estexp_jax.discovery.hypotheses import Hypothesis, Place, claiming
from estexp_jax.discovery.location import element
from estexp_jax.discovery.selection import Explanation, Selection
from estexp_jax.physics.effects.laws.base import UNKNOWN_LAW
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot

_SAME = 1.03
"""Held-out squared errors this near to the chosen one's are no wrong effect's: the data cannot tell the two apart."""


def placebo(robot: Robot, parameters: Hypothesis, selection: Selection) -> Task | None:
    """The wrong hypothesis and the vectors to fit it from; None where nothing is claimed or no other effect was tried.

    Args:
        robot: the nominal robot.
        parameters: the hypothesis that only values of the model are off.
        selection: what was tried and chosen.
    """
    wrong: list[Explanation] = []
    for claim in selection.chosen.places:
        others = [e for e in _wrong(robot, selection) if e.places[0] not in [w.places[0] for w in wrong]]
        if others:
            apart = [abs(_parameters(e.places[0]) - _parameters(claim)) for e in others]
            nearest = [e for e, n in zip(others, apart, strict=True) if n == min(apart)]
            wrong.append(min(nearest, key=lambda e: e.error))
    if not wrong:
        return None
    hypothesis = claiming(robot, parameters, [e.places[0] for e in wrong])
    return hypothesis, [hypothesis.start(), *(_joined(hypothesis, first, wrong) for first in wrong)]


def _wrong(robot: Robot, selection: Selection) -> Sequence[Explanation]:
    """Single effects tried that are not claimed; without the claimed ones' likenesses, if any are left then."""
    chosen = selection.chosen
    others = [e for e in selection.tried if len(e.places) == 1 and e.places[0] not in chosen.places]
    claimed = {_likeness(robot, place) for place in chosen.places}
    alike = len(chosen.places) == 1
    told_apart = [e for e in others if not (alike and e.held_out.sum() <= _SAME * chosen.held_out.sum())]
    return [e for e in told_apart if _likeness(robot, e.places[0]) not in claimed] or told_apart


def _likeness(robot: Robot, place: Place) -> tuple[str, str | None, str]:
    """Element and simplest relative of an effect: what two effects share that are one law in richer and simpler form.

    Damping by the joint and by the motor that drives it are one while motors are on.
    """
    e = effect(place[0])
    if not e.named:
        return (*element(robot, place), UNKNOWN_LAW)
    e = effect(e.variant_of or e.name)
    while e.nested_in:
        e = effect(e.nested_in)
    return (*element(robot, place), e.alike_while_on or e.name)


def _parameters(place: Place) -> int:
    return len(effect(place[0]).parameters)


def _joined(hypothesis: Hypothesis, first: Explanation, wrong: Sequence[Explanation]) -> np.ndarray:
    """The vector (n_free,) at which wrong effects are as fitted alone, the model's values as beside `first`."""
    known: dict[tuple[str, str, str], float] = {}
    for e in (first, *wrong):
        free = zip(e.fitted.hypothesis.free, e.fitted.vector, strict=True)
        known |= {(f.effect, f.site, f.parameter): v for f, v in free if e is first or (f.effect, f.site) in e.places}
    return np.array([known.get((f.effect, f.site, f.parameter), f.neutral) for f in hypothesis.free])
