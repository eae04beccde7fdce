"""The vector of everything that may differ between a robot and its nominal model: one entry a parameter of an effect.

All hypotheses of one robot and one catalogue are points of this space. At `neutral` nothing differs.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import final

import numpy as np

from estexp_jax.physics.effects.changes import Change, Values, neutral
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.model.robot import Robot

Place = tuple[str, str]
"""An effect's name and a site."""
_MOST_LOST = 0.9
"""Share of a value of the model that it may be too large by: a body without mass cannot be simulated."""


@final
@dataclass(frozen=True)
class SiteParameter:
    """One parameter of one effect at one site.

    Attributes:
        effect, site, name: what it is.
        row, column: where it stands in the effect's value array.
        low, high: bounds, in its unit.
        neutral: the value at which the effect is absent.
        nominal: the model's own value that it adds to, in its unit; 0 where the model has none.
        categorical: whether it names an element or has but one value, so that no derivative exists.
    """

    effect: str
    site: str
    name: str
    row: int
    column: int
    low: float
    high: float
    neutral: float
    nominal: float = 0.0
    categorical: bool = False

    @property
    def place(self) -> Place:
        """Effect and site."""
        return self.effect, self.site

    @property
    def size(self) -> float:
        """Largest distance from neutral within the bounds, in its unit; of what is never neutral, the range."""
        if self.low <= self.neutral <= self.high:
            return max(self.high - self.neutral, self.neutral - self.low)
        return self.high - self.low


@final
@dataclass(frozen=True, eq=False)
class ParameterSpace:
    """All parameters of a catalogue on a robot.

    Attributes:
        robot: the nominal robot.
        catalogue: the effects.
        parameters: (n,) in the catalogue's order.
    """

    robot: Robot
    catalogue: Catalogue
    parameters: tuple[SiteParameter, ...]

    @cached_property
    def neutral(self) -> np.ndarray:
        """The point (n,) of the nominal model."""
        return np.array([p.neutral for p in self.parameters])

    @cached_property
    def bounds(self) -> np.ndarray:
        """(n, 2) lowest and highest values; a value of the model may fall to none of it."""
        ends = [[min(p.low, -_MOST_LOST * p.nominal), max(p.high, p.neutral)] for p in self.parameters]
        return np.array(ends).reshape(-1, 2)

    @cached_property
    def of_place(self) -> dict[Place, np.ndarray]:
        """Indices of each place's parameters."""
        found: dict[Place, list[int]] = {}
        for i, p in enumerate(self.parameters):
            found.setdefault(p.place, []).append(i)
        return {place: np.array(indices) for place, indices in found.items()}

    def values(self, points: np.ndarray) -> Values:
        """Effects' values (points, n_sites, n_parameters) of points (points, n)."""
        base = neutral(self.robot, self.catalogue)
        found = {name: np.repeat(v[None], len(points), axis=0) for name, v in base.items()}
        for i in np.flatnonzero((points != self.neutral).any(axis=0)):
            p = self.parameters[i]
            found[p.effect][:, p.row, p.column] = points[:, i]
        return found

    def changes(self, point: np.ndarray, places: Collection[Place] | None = None) -> tuple[Change, ...]:
        """The changes that a point (n,) stands for: all that differ from neutral, or those of some places."""
        found: list[Change] = []
        for place, indices in self.of_place.items():
            if (place in places) if places is not None else bool((point[indices] != self.neutral[indices]).any()):
                values = {self.parameters[i].name: float(point[i]) for i in indices}
                found.append(Change(place[0], place[1] or None, values))
        return tuple(found)


def parameter_space(robot: Robot, catalogue: Catalogue) -> ParameterSpace:
    """All parameters of a catalogue on a robot."""
    found: list[SiteParameter] = []
    for e in catalogue:
        for row, site in enumerate(e.sites(robot)):
            bounds = e.searched_bounds(robot, site)
            nominal = e.nominal_value(robot, site) if e.model_attribute is not None and site != ALL_ALIKE else 0.0
            for column, (p, (low, high)) in enumerate(zip(e.parameters, bounds, strict=True)):
                fixed = bool(p.refers) or low == high
                own = nominal if column == 0 else 0.0
                found.append(SiteParameter(e.name, site, p.name, row, column, low, high, p.neutral, own, fixed))
    return ParameterSpace(robot, tuple(catalogue), tuple(found))


def nuisances(space: ParameterSpace, known: Collection[Place] = ()) -> list[int]:
    """Indices of the parameters that change a value the model has, which every hypothesis may refit a little.

    Args:
        space: of the robot.
        known: places whose values are given for each recording.
    """
    return [i for i, p in enumerate(space.parameters) if p.nominal > 0.0 and p.place not in known]


def with_values(space: ParameterSpace, point: np.ndarray, place: Place, values: Sequence[float]) -> np.ndarray:
    """A point (n,) with other values of one place, within their bounds."""
    found, indices = point.copy(), space.of_place[place]
    found[indices] = np.clip(values, *space.bounds[indices].T)
    return found
