"""Effects of the user's own, beside the catalogue."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from estexp_jax.errors import InputError
from estexp_jax.package_data import model_path
from estexp_jax.physics.effects import registry
from estexp_jax.physics.effects.base import Effect
from estexp_jax.physics.effects.checks import effect_faults
from estexp_jax.physics.model.robot import Robot

_E = TypeVar("_E", bound=Effect)
_TRIED = ("leg", "quadruped")
"""Models that an effect is tried on."""


def register(effect: _E, robots: Sequence[Robot] = ()) -> _E:
    """Put an effect of your own beside the catalogue, for this process.

    From then on it can be planted (`record`), it is fitted, chosen and reported by `explain` like any other, and
    `load_explained` reads results that name it. An effect of yours with the same name is replaced.

    Args:
        effect: an instance of your class; see the page on writing an effect.
        robots: on which it is tried first; by default a leg with servos and a quadruped.

    Returns:
        The effect.

    Raises:
        InputError: a law that every effect obeys does not hold: places that exist, finite bounds, a sentence that names
            place and numbers, no change at neutral values, ...; or the program has an effect of that name.
    """
    found = effect_faults(effect)
    if not found:
        registry.add(effect)
        tried = robots or [Robot.from_xml(model_path(name)) for name in _TRIED]
        found = next((wrong for wrong in (effect_faults(effect, robot) for robot in tried) if wrong), [])
    if found:
        registry.drop(effect)
        raise InputError(found[0], where=f"the effect {type(effect).__name__}", right="see docs/effects.md")
    return effect
