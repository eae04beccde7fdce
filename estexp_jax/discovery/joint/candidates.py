"""Directions in which a robot may differ from its model: one for each first guess of each effect at each place."""

from __future__ import annotations

from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import NamedTuple, final

import numpy as np

from estexp_jax.discovery.joint.criteria import SelectionCriteria
from estexp_jax.estimation.parameters import ParameterSpace, Place, with_values
from estexp_jax.physics.effects.effect import NEVER
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.effects.sites import ALL_ALIKE

_LEAST_STEP, _STEP = 1e-3, 0.01
"""Finite-difference steps, as a share of a parameter's range, and of its distance from neutral."""


class Candidate(NamedTuple):
    """An effect at a place with values to try it at.

    Attributes:
        place: effect and site.
        direction: (n,) difference from neutral.
        least, most: multiples of the direction that may be taken.
        numbers: how many parameters it fixes.
    """

    place: Place
    direction: np.ndarray
    least: float
    most: float
    numbers: int

    def at(self, times: float) -> np.ndarray:
        """Difference (n,) from neutral at a multiple; where the effect is far from linear, only the guess itself."""
        return self.direction if self.least > 0.0 else times * self.direction


def candidates(
    space: ParameterSpace, observed: Observed, places: Collection[Place], *, additive: bool
) -> list[Candidate]:
    """All first guesses of the effects at some places that are additive, or that are not.

    Values that stand for all elements alike are left out: each element has its own. So is what grows in time, which no
    short window shows.
    """
    found: list[Candidate] = []
    for place in space.of_place:
        e = effect(place[0])
        if place not in places or e.additive != additive or place[1] == ALL_ALIKE or e.grows_in_time:
            continue
        guesses = e.initial_guesses(space.robot, place[1], observed)
        directions = [with_values(space, space.neutral, place, values) - space.neutral for values in guesses]
        own = [Candidate(place, d, *_multiples(space, d), len(e.parameters)) for d in directions if d.any()]
        found += _alone(own) if len(e.parameters) == 1 and all(c.least == 0.0 for c in own) else own
    return found


def _alone(guesses: list[Candidate]) -> list[Candidate]:
    """Of guesses of a single number, a small and a moderate one to each side: multiples of these are all others."""
    sides = [[c for c in guesses if (c.direction.sum() > 0.0) == up] for up in (True, False)]
    ranked = [sorted(side, key=lambda c: float(np.abs(c.direction).sum())) for side in sides]
    return [c for side in ranked for c in side[:2]]


def log_odds(names: Sequence[Place], criteria: SelectionCriteria) -> np.ndarray:
    """Prior log odds of candidates, nats, from the places they stand for: one place's guesses share its odds."""
    places, counts = list(dict.fromkeys(names)), Counter(names)
    odds = np.log(criteria.expected_effects / max(len(places) - criteria.expected_effects, 1.0))
    native = {p: criteria.native_odds * (effect(p[0]).model_attribute is not None) for p in places}
    return np.array([odds + native[p] - np.log(counts[p]) for p in names])


def _multiples(space: ParameterSpace, direction: np.ndarray) -> tuple[float, float]:
    """Least and largest multiple of a direction that may be taken.

    It must fit into the bounds of ratios; amounts with a unit may be any multiple, since their bounds come from what
    motors could do, which says little of what a robot does. Limits, which are far away where there is none, and
    what refers to an element are not linear: of these only about the guess itself.
    """
    times = np.inf
    for i in np.flatnonzero(direction):
        p = space.parameters[i]
        if abs(p.neutral) >= NEVER or p.categorical:
            return 0.5, 2.0
        unit = next(q.unit for q in effect(p.effect).parameters if q.name == p.name)
        if not unit:
            end = space.bounds[i, 1] if direction[i] > 0.0 else space.bounds[i, 0]
            times = min(times, (end - p.neutral) / direction[i])
    return 0.0, float(times)


@final
@dataclass(frozen=True, eq=False)
class Derivatives:
    """Finite-difference directions of parameters at a point.

    Attributes:
        indices: (k,) of the parameters.
        directions: (k, n), a step of one parameter each.
        steps: (k,).
    """

    indices: np.ndarray
    directions: np.ndarray
    steps: np.ndarray


def derivatives(space: ParameterSpace, point: np.ndarray, indices: Sequence[int] | np.ndarray) -> Derivatives:
    """Directions along single parameters, inwards where a bound is near."""
    directions = np.zeros((len(indices), len(point)))
    steps = np.zeros(len(indices))
    for row, i in enumerate(indices):
        p = space.parameters[int(i)]
        step = max(_STEP * abs(point[i] - p.neutral), _LEAST_STEP * (p.nominal or p.size))
        steps[row] = -step if point[i] + step > space.bounds[i, 1] else step
        directions[row, i] = steps[row]
    return Derivatives(np.asarray(indices, dtype=int), directions, steps)
