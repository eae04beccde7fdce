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
from estexp_jax.physics.model.robot import Robot

_SMALL = 0.02
"""Share of a first guess that is small."""
_LEAST_STEP, _STEP = 1e-3, 0.01
"""Finite-difference steps, as a share of a parameter's range, and of its distance from neutral."""


class Candidate(NamedTuple):
    """An effect at a place with values to try it at.

    Attributes:
        place: effect and site.
        direction: (n,) difference from neutral.
        amounts: (n,) which of its numbers are amounts, which multiples of it scale; others say where or when it acts.
        least, most: multiples of the direction that may be taken.
        numbers: how many parameters it fixes.
    """

    place: Place
    direction: np.ndarray
    amounts: np.ndarray
    least: float
    most: float
    numbers: int

    def at(self, times: float) -> np.ndarray:
        """Difference (n,) from neutral at a multiple; where the effect is far from linear, only the guess itself."""
        return np.where(self.amounts & (self.least <= 0.0), times * self.direction, self.direction)

    def as_derivative(self) -> Candidate:
        """The same with amounts so small that readings are linear in them, where any multiple may be taken."""
        if self.least > 0.0:
            return self
        direction = np.where(self.amounts, _SMALL * self.direction, self.direction)
        return self._replace(direction=direction, most=self.most / _SMALL)


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
        names = [p.name for p in e.parameters]
        guesses = [
            values
            for values in e.initial_guesses(space.robot, place[1], observed)
            if e.identifiable(space.robot, place[1], dict(zip(names, values, strict=False)), observed)
        ]
        directions = [with_values(space, space.neutral, place, values) - space.neutral for values in guesses]
        amounts = _amounts(space, place)
        own = [Candidate(place, d, amounts, *_multiples(space, d), len(e.parameters)) for d in directions if d.any()]
        found += _smallest(space, own) if e.additive else own
    return found


def _amounts(space: ParameterSpace, place: Place) -> np.ndarray:
    """Which parameters (n,) of a place have the unit of its first one: they grow together."""
    found = np.zeros(len(space.parameters), dtype=bool)
    units = [p.unit for p in effect(place[0]).parameters]
    found[space.of_place[place]] = [unit == units[0] for unit in units]
    return found


def _smallest(space: ParameterSpace, guesses: list[Candidate]) -> list[Candidate]:
    """Of guesses that differ in the amount alone, the smallest to each side: it is nearest to a derivative."""
    kept: dict[tuple[float, ...], Candidate] = {}
    for c in guesses:
        own = c.direction[space.of_place[c.place]]
        shape = (np.sign(own[0]), *own[1:]) if len(own) > 1 and own[0] else tuple(np.sign(own))
        if shape not in kept or abs(own[0]) < abs(kept[shape].direction[space.of_place[c.place][0]]):
            kept[shape] = c
    return list(kept.values())


def log_odds(
    names: Sequence[Place],
    criteria: SelectionCriteria,
    robot: Robot,
    among: Collection[Place] = (),
    present: Collection[Place] = (),
) -> np.ndarray:
    """Prior log odds of candidates, nats, from the places they stand for: one place's guesses share its odds.

    An effect may be missing at a place by itself, or because its kind is missing at the robot's other places: friction
    that five of six like gears have is expected in the sixth.

    Args:
        names: the place of each.
        criteria: how many effects are expected.
        robot: the nominal robot.
        among: all places where something may be missing; none: those that are named.
        present: places of effects that are taken to be there.

    Source: Scott and Berger, Annals of Statistics 38 (2010), multiplicity; Pearl, Probabilistic Reasoning (1988), the
    noisy or.
    """
    places, counts = list(dict.fromkeys(names)), Counter(names)
    every = set(among or places)
    alone = min(criteria.expected_effects / max(len(every), 1), 0.5)
    found = {}
    for place in places:
        kind = [p for p in every if p[0] == place[0] and p[1] != ALL_ALIKE]
        others = sum(p[0] == place[0] and p != place for p in present) / max(len(kind), 1)
        absent = (1.0 - alone) * (1.0 - min(others, criteria.most_alike))
        found[place] = np.log((1.0 - absent) / absent)
    native = {p: criteria.native_odds * _is_left_out(robot, p) for p in places}
    return np.array([found[p] + native[p] - np.log(counts[p]) for p in names])


def _is_left_out(robot: Robot, place: Place) -> bool:
    """Whether MJCF has a value for it, and the model leaves it at nothing, as most models do."""
    e = effect(place[0])
    return e.model_attribute is not None and e.nominal_value(robot, place[1]) == 0.0


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
        if not unit or (p.nominal > 0.0 and direction[i] < 0.0):
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
