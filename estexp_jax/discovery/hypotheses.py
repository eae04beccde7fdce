"""Hypotheses: which effects are present where, with the parameters that are free under them.

Every hypothesis, also the one that nothing is missing, may bend the values the model already has by up to 30 %: masses,
motor strengths, dampings, armatures. Otherwise small errors there would pass for missing physics.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from estexp_jax.physics.effects.changes import Change, Values, encode, neutral
from estexp_jax.physics.effects.registry import Catalogue, effect, every, logging_faults
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.model.robot import Robot

Place = tuple[str, str]
"""An effect's name and a site."""

TOLERANCE = 0.3
"""Share by which a value of the model may be off and still count as a wrong parameter."""
_ORDINARY = 0.03
"""Share by which values of models usually are off."""


def model_values() -> tuple[str, ...]:
    """Names of the effects that change values a model has; all of them are fitted beside whatever is claimed."""
    return tuple(e.name for e in every() if e.model_attribute is not None)


def claimable(effects: Sequence[str]) -> tuple[str, ...]:
    """Names of effects with their other forms, and unknown laws like them; faults of logging are decided before."""
    logging = {e.name for e in logging_faults()}
    effects = [name for name in effects if name not in logging]
    related = ((e.name, e.variant_of or e.tried_beside) for e in every())
    return (*effects, *(other for other, name in related if name in effects))


def told_of(place: Place) -> Place:
    """The effect at the site that a form of it is told as."""
    return effect(place[0]).variant_of or place[0], place[1]


def simulated(effects: Sequence[str]) -> tuple[str, ...]:
    """Names of all that a simulator must know for these to be claimed, values of the model bent beside them."""
    claimed = claimable(effects)
    return (*claimed, *(name for name in model_values() if name not in claimed))


@final
@dataclass(frozen=True)
class Free:
    """One free parameter.

    Attributes:
        effect, site, parameter: what it is.
        row, column: its place in the effect's value array.
        low, high: bounds, in its unit.
        neutral: where it does nothing.
        spread: deviation that counts as ordinary for a value of the model; infinite for an effect's own parameter.
        chosen: whether it names an element or has but one value: then only starts choose it, no step moves it.
        present: the model's own value that it adds to; that times (1 - it) for a loss.
        loss: whether it is one.
    """

    effect: str
    site: str
    parameter: str
    row: int
    column: int
    low: float
    high: float
    neutral: float
    spread: float
    chosen: bool = False
    present: float = 0.0
    loss: bool = False

    @property
    def origin(self) -> float:
        """Where it does nothing, or 0 where that is out of reach."""
        return self.neutral if self.low <= self.neutral <= self.high else 0.0

    @property
    def size(self) -> float:
        """Largest distance from neutral, the scale of steps; of what is never neutral, its range."""
        if self.low <= self.neutral <= self.high:
            return max(abs(self.low - self.neutral), abs(self.high - self.neutral))
        return self.high - self.low


@final
@dataclass(frozen=True)
class Hypothesis:
    """Some effects at some places, over parameters of the model that may be off a little.

    Attributes:
        places: the effects that are claimed; empty: only parameters are off.
        free: all free parameters, the claimed effects' last.
    """

    places: tuple[Place, ...]
    free: tuple[Free, ...]

    @property
    def label(self) -> str:
        """`effect@site` of each claimed effect, joined by +; `parameters` if there is none."""
        return " + ".join(f"{e}@{s}" if s else e for e, s in self.places) or "parameters"

    def start(self) -> np.ndarray:
        """The vector (n_free,) at which nothing differs from the nominal model."""
        return np.array([f.neutral for f in self.free])

    def bounds(self) -> np.ndarray:
        """The lowest and the highest values (2, n_free)."""
        return np.array([[f.low for f in self.free], [f.high for f in self.free]])

    def with_values(self, place: Place, values: Sequence[float]) -> np.ndarray:
        """The vector (n_free,) at which one effect has these values, within its bounds, and nothing else differs."""
        start = self.start()
        own = [i for i, f in enumerate(self.free) if (f.effect, f.site) == place]
        for i, value in zip(own, values, strict=True):
            start[i] = np.clip(value, self.free[i].low, self.free[i].high)
        return start

    def unclaimed(self, vector: np.ndarray) -> np.ndarray:
        """The vector (n_free,) with nothing of what is claimed in it."""
        claimed = np.array([(f.effect, f.site) in self.places for f in self.free], dtype=bool)
        return np.where(claimed, self.start(), vector)

    def changes(self, vector: np.ndarray, *, claimed: bool | None = None) -> tuple[Change, ...]:
        """The changes a vector (n_free,) stands for: all, only the claimed ones, or only the others."""
        found: dict[Place, dict[str, float]] = {}
        for f, value in zip(self.free, vector, strict=True):
            if claimed is None or claimed == ((f.effect, f.site) in self.places):
                found.setdefault((f.effect, f.site), {})[f.parameter] = float(value)
        return tuple(Change(e, s or None, parameters) for (e, s), parameters in found.items())


def parameters_only(robot: Robot, catalogue: Catalogue, known: Collection[Place] = ()) -> Hypothesis:
    """The hypothesis that only values of the model are off.

    Args:
        robot: the nominal robot.
        catalogue: the effects; those that change a value the model has say which values.
        known: values that are given for each recording, so not in doubt.
    """
    free = (f for e in catalogue for f in _nuisance(robot, e.name))
    return Hypothesis((), tuple(f for f in free if (f.effect, f.site) not in known))


def claiming(robot: Robot, parameters: Hypothesis, places: Sequence[Place]) -> Hypothesis:
    """The hypothesis that claims effects at places, over or instead of small errors of parameters."""
    own = [f for place in places for f in _own(robot, place)]
    claimed = {(f.effect, f.site) for f in own}
    others = [f for f in parameters.free if (f.effect, f.site) not in claimed]
    return Hypothesis(tuple(places), tuple(others + own))


def known_values(robot: Robot, settings: Iterable[str]) -> set[Place]:
    """The values of the model that recordings' settings give, as the effects that would bend them."""
    found: set[Place] = set()
    for setting in settings:
        element, _, rest = setting.partition(".")
        name, _, attribute = rest.rpartition(".")
        given = (element, "*"), (element, attribute)
        found |= {(e.name, name) for e in every() if e.model_attribute in given}
    return found


def singles(robot: Robot, catalogue: Catalogue) -> list[Place]:
    """Every effect of a catalogue at every place."""
    return [(e.name, site) for e in catalogue for site in e.sites(robot)]


def batch(
    robot: Robot,
    catalogue: Catalogue,
    members: Sequence[tuple[Hypothesis, np.ndarray]],
    standing: Sequence[Change] = (),
) -> Values:
    """Values (members, n_sites, n_parameters) of hypotheses with their vectors (n_free,).

    What the robot has under every hypothesis (`standing`) is in all of them; what is claimed at the same place adds.
    """
    base = encode(robot, catalogue, standing) if standing else neutral(robot, catalogue)
    values = {name: np.repeat(v[None], len(members), axis=0) for name, v in base.items()}
    for i, (hypothesis, vector) in enumerate(members):
        for f, value in zip(hypothesis.free, vector, strict=True):
            there = base[f.effect][f.row, f.column]
            adds = standing and not f.chosen and there != np.float32(f.neutral)
            values[f.effect][i, f.row, f.column] = there + value - f.neutral if adds else value
    return values


def lanes(
    robot: Robot,
    catalogue: Catalogue,
    members: Sequence[tuple[Hypothesis, np.ndarray]],
    early: Sequence[bool],
    standing: Sequence[Change] = (),
) -> Values:
    """Values (members x windows, n_sites, n_parameters); in windows that are early, nothing claimed acts yet."""
    late = {name: np.repeat(v, len(early), axis=0) for name, v in batch(robot, catalogue, members, standing).items()}
    if not any(early):
        return late
    before = batch(robot, catalogue, [(h, h.unclaimed(v)) for h, v in members], standing)
    here = np.tile(early, len(members))[:, None, None]
    return {name: np.where(here, np.repeat(before[name], len(early), axis=0), v) for name, v in late.items()}


def _own(robot: Robot, place: Place) -> list[Free]:
    name, site = place
    e = effect(name)
    row = e.sites(robot).index(site)
    own = [
        Free(name, site, p.name, row, column, low, high, p.neutral, np.inf, chosen=bool(p.refers) or low == high)
        for column, (p, (low, high)) in enumerate(zip(e.parameters, e.searched_bounds(robot, site), strict=True))
    ]
    bent = {(f.site, f.parameter): f for f in _nuisance(robot, name)}
    known = [(f, bent.get((f.site, f.parameter), f)) for f in own]
    return [replace(f, present=value.present, loss=value.loss) for f, value in known]


def _nuisance(robot: Robot, name: str) -> list[Free]:
    """The small errors of a catalogue's effect that changes a value the model already has."""
    e = effect(name)
    if e.model_attribute is None:
        return []
    sites = [site for site in e.sites(robot) if site != ALL_ALIKE]
    p, reach = e.parameters[0], TOLERANCE * np.array([e.nominal_value(robot, site) for site in sites])
    return [
        Free(name, site, p.name, row, 0, -r, r, 0.0, _ORDINARY / TOLERANCE * r, present=r / TOLERANCE, loss=e.is_loss)
        for row, (site, r) in enumerate(zip(sites, reach, strict=True))
        if r > 0.0
    ]
