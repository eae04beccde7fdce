"""How right a diagnosis is."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.model.robot import Robot

_FULL: dict[str, float] = {"gravity_tilt": np.pi / 6}
"""What counts as 100 points of an amount, where it is not 1; of a mass it is the nominal one."""


def same_set(planted: Sequence[Change], diagnosis: Sequence[Change]) -> bool:
    """Whether a diagnosis names every change, its place, and no other."""
    return _places(planted) == _places(diagnosis)


def amount_error(robot: Robot, planted: Sequence[Change], diagnosis: Sequence[Change]) -> float | None:
    """Largest error of an amount, points of a hundred; None where the set is wrong or has no amounts."""
    if not same_set(planted, diagnosis):
        return None
    found = {change.place: change for change in diagnosis}
    pairs = [(change, found[change.place]) for change in planted]
    errors = [
        abs(_points(robot, a) - _points(robot, b)) for a, b in pairs if a.effect not in ("part_lost", "tied_outputs")
    ]
    return max(errors) if errors else None


def _points(robot: Robot, change: Change) -> float:
    value = next(iter(change.parameters.values()))
    if change.effect == "body_mass":
        return 100.0 * value / float(robot.model.body_mass[robot.index("body", change.name or "")])
    return 100.0 * value / _FULL.get(change.effect, 1.0)


def text(changes: Sequence[Change]) -> str:
    """In one line."""
    said = (f"{c.place} " + " ".join(f"{k}={v:.3g}" for k, v in c.parameters.items()) for c in changes)
    return "; ".join(sorted(said)) or "nothing"


def kinds(changes: Sequence[Change]) -> tuple[str, ...]:
    """The effects alone, sorted."""
    return tuple(sorted(change.effect for change in changes))


def _places(changes: Sequence[Change]) -> list[tuple[str, str]]:
    return sorted((change.place, _partner(change)) for change in changes)


def _partner(change: Change) -> str:
    """Tied motors name each other: the other one is a place, too."""
    return f"{change.parameters['with']:g}" if change.effect == "tied_outputs" else ""
