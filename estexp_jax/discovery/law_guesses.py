"""Which terms of an unknown law the forces that a joint lacks suggest, and with which values.

Each term of the library is laid beside the missing force, at many values of its shape; compared is what is left of both
without what wrong values of the model would explain. Where the joint often rests, that is done for its motion alone,
too. A look only: what the terms do is found in the simulation.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.hypotheses import Place, model_values
from estexp_jax.discovery.law_forces import Samples, force_of, samples_of
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.laws.base import JointLaw
from estexp_jax.physics.effects.laws.library import law_terms
from estexp_jax.physics.effects.registry import every
from estexp_jax.physics.model.robot import Robot

_COLUMNS, _STARTS = 64, 4
"""Values of a term that are laid beside the missing force at once, and those that are kept."""
_ROUNDS, _NARROWER = 4, 0.4
"""Each of these is moved so often to the best of as many values around it, drawn from a range that narrows so."""
_SAME = 1e-3
"""Values that differ by less, as a share of their bounds, are one."""
_LITTLE = 1e-3
"""Share of the largest amplitude at which a force is still in proportion to it."""
_ALIKE = 1e-6
"""Share of a force's square; if less than that is left of it, it is what wrong values of the model look like."""


class _Law(NamedTuple):
    """A term at a joint: bounds (n_parameters, 2), the amplitude first, and shapes to begin with."""

    law: JointLaw
    bounds: np.ndarray
    tried: list[tuple[float, ...]]

    def clipped(self, shapes: np.ndarray) -> list[tuple[float, ...]]:
        """Shapes (n, n_shape) within their bounds."""
        return [tuple(s) for s in np.clip(shapes, *self.bounds[1:].T).tolist()]


class _Beside(NamedTuple):
    """A term at some values beside the missing force: share of its square that it takes out."""

    share: float
    values: tuple[float, ...]


def resembling_model_values() -> set[str]:
    """Effects that wrong values of a model do, or look like: a motor that brakes looks like damping while it is on."""
    wrong = model_values()
    return {e.name for e in every() if e.name in wrong or e.alike_while_on in wrong}


def likely(
    robot: Robot, seen: Sequence[ForceResidual], joint: str, n: int, named: Collection[str] = ()
) -> dict[Place, Vectors]:
    """The terms at a joint that take out most of the force that it lacks, with values to start from.

    With them are those that say what values of a model say, where these values may not be claimed: a look cannot tell.

    Args:
        robot: the nominal robot.
        seen: what its joints lack, in each training recording.
        joint: the joint's name.
        n: how many terms are wanted.
        named: effects of the catalogue that may be claimed: terms that say the same do not count.
    """
    asked = [law for law in law_terms() if law.stands_for not in named]
    found = _looked_for(robot, seen, joint, asked)
    ranked = sorted((law for law in asked if found.get(law)), key=lambda law: -found[law][0].share)
    resembling = resembling_model_values()
    wanted = [law for i, law in enumerate(ranked) if i < n or law.stands_for in resembling]
    return {(law.name, joint): [b.values for b in found[law]] for law in wanted}


def likely_values(
    robot: Robot, seen: Sequence[ForceResidual], joint: str, names: Collection[str]
) -> dict[Place, Vectors]:
    """Values to start effects of the catalogue from at a joint, by the terms that say the same.

    Args:
        robot: the nominal robot.
        seen: what its joints lack, in each training recording.
        joint: the joint's name.
        names: of the effects.
    """
    found = _looked_for(robot, seen, joint, [law for law in law_terms() if law.stands_for in names])
    return {(law.stands_for, joint): [b.values for b in best] for law, best in found.items()}


def _looked_for(
    robot: Robot, seen: Sequence[ForceResidual], joint: str, laws: Iterable[JointLaw]
) -> dict[JointLaw, list[_Beside]]:
    """The best values of each term at a joint, of those that have any to begin with."""
    samples = samples_of(robot, seen, robot.index("joint", joint))
    moving = samples.moving()
    looks = [samples] if moving is None else [samples, moving]
    tried = [_Law(law, np.array(law.bounds(robot, joint)), law.initial_shapes(samples.reach)) for law in laws]
    return {law.law: _best(b for look in looks for b in _beside(law, look)) for law in tried if law.tried}


def _best(found: Iterable[_Beside]) -> list[_Beside]:
    """The few that take out most, the best one first."""
    return sorted(found, key=lambda b: b.share, reverse=True)[:_STARTS]


def _beside(law: _Law, samples: Samples) -> list[_Beside]:
    """The best values of a term, the best one first; [] where it can do nothing."""
    found = _explained(law, law.clipped(np.array(law.tried, float)), samples)
    best = list(reversed({b.values: b for b in sorted(found, key=lambda b: b.share)}.values()))[:_STARTS]
    moved = sorted((_moved(law, b, samples) for b in best), key=lambda b: b.share, reverse=True)
    scale = np.maximum(np.ptp(law.bounds, axis=1), 1e-30) * _SAME
    distinct = {tuple(np.round(b.values / scale)): b for b in reversed([*moved, *best]) if b.values[0] != 0.0}
    return _best(distinct.values())


def _moved(law: _Law, best: _Beside, samples: Samples) -> _Beside:
    """The same between the values that were tried, where it takes out most; what remembers is looked at too slowly."""
    free = np.array([not p.refers for p in law.law.parameters[1:]], bool)
    if law.law.n_states or not free.any():
        return best
    tried, rng = np.array(law.tried, float), np.random.default_rng(0)
    width = np.array([_gap(tried[:, k], best.values[1 + k]) for k in range(len(free))]) * free
    for _ in range(_ROUNDS):
        around = best.values[1:] + width * rng.standard_normal((_COLUMNS, len(free)))
        best = max((best, *_explained(law, law.clipped(around), samples)), key=lambda b: b.share)
        width *= _NARROWER
    return best


def _gap(tried: np.ndarray, value: float) -> float:
    """How far apart values that were tried are near one of them; as much as itself where it is the only one."""
    grid = np.unique(tried)
    return float(np.interp(value, grid, np.gradient(grid))) if len(grid) > 1 else abs(value)


def _explained(law: _Law, shapes: Sequence[tuple[float, ...]], samples: Samples) -> list[_Beside]:
    """What a term of each shape takes out of the missing force."""
    found: list[_Beside] = []
    for part, columns in _columns(law.law, _LITTLE * law.bounds[0, 1], shapes, samples):
        found += _taken(part, columns, law.bounds[0], samples)
    return found


def _taken(
    shapes: Sequence[tuple[float, ...]], columns: np.ndarray, bound: np.ndarray, samples: Samples
) -> list[_Beside]:
    """What each column takes out of the missing force beside wrong values of the model, and alone.

    What looks like wrong values of the model takes nothing out; it is still a start, by all that it resembles.
    """
    whole = np.sum(columns**2, axis=0)
    left, force = _without(samples.bent, columns), _without(samples.bent, samples.force[:, None])[:, 0]
    found: list[_Beside] = []
    for own, y, counts in ((left, force, True), (columns, samples.force, False)):
        size, along = np.sum(own**2, axis=0), own.T @ y
        amplitude = np.where(size > _ALIKE * whole, along, 0.0) / np.maximum(size, 1e-30)
        share = amplitude * along / max(float(force @ force), 1e-30) if counts else np.zeros(len(shapes))
        share, amplitude = _allowed(share, amplitude, bound)
        values = zip(share.tolist(), amplitude.tolist(), shapes, strict=True)
        found += [_Beside(s, (a, *map(float, shape))) for s, a, shape in values]
    return found


def _allowed(share: np.ndarray, amplitude: np.ndarray, bound: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Amplitudes within their bounds; what would need another sign takes nothing out, and starts from little."""
    low, high = bound
    wrong = (amplitude < low) & (low == 0.0)
    return np.where(wrong, 0.0, share), np.where(wrong, 0.01 * high, np.clip(amplitude, low, high))


def _without(basis: np.ndarray, columns: np.ndarray) -> np.ndarray:
    return columns - basis @ (basis.T @ columns)


def _columns(
    law: JointLaw, amplitude: float, shapes: Sequence[tuple[float, ...]], samples: Samples
) -> Iterator[tuple[Sequence[tuple[float, ...]], np.ndarray]]:
    """Shapes with the force (samples, shapes) of a term of amplitude 1 at them."""
    for first in range(0, len(shapes), _COLUMNS):
        part = shapes[first : first + _COLUMNS]
        filled = np.resize(np.array(part, float).reshape(len(part), -1), (_COLUMNS, len(part[0])))  # compiles once
        p = (np.full(_COLUMNS, amplitude), *filled.T)
        yield part, force_of(law, p, samples)[:, : len(part)] / amplitude
