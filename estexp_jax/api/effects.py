"""The effects that the program knows, and those of the user's own beside them."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from typing import TypeVar, final

from estexp_jax.errors import InputError
from estexp_jax.package_data import model_path
from estexp_jax.physics.effects import registry
from estexp_jax.physics.effects.checks import effect_faults
from estexp_jax.physics.effects.effect import Effect
from estexp_jax.physics.model.robot import Robot

_E = TypeVar("_E", bound=Effect | type[Effect])
_TRIED = ("leg", "quadruped")
"""Models that an effect is tried on."""
_HEADER = ("effect", "acts on", "side", "parameters", "equation")


@final
class EffectList(tuple[Effect, ...]):
    """Effects that print as a table."""

    __slots__ = ()

    def __repr__(self) -> str:
        rows = [_HEADER, *map(_row, self)]
        widths = [max(len(row[i]) for row in rows) for i in range(len(_HEADER) - 1)]
        return "\n".join("  ".join((*(c.ljust(w) for c, w in zip(r, widths, strict=False)), r[-1])) for r in rows)

    def _repr_html_(self) -> str:
        head = "".join(f"<th>{name}</th>" for name in _HEADER)
        body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in _row(e))}</tr>" for e in self)
        return f"<table><tr>{head}</tr>{body}</table>"


def effects() -> EffectList:
    """The effects that can be planted, recovered from or found: the catalogue, then those of your own."""
    return EffectList(registry.named_effects())


def register(effect: _E, robots: Sequence[Robot] = ()) -> _E:
    """Put an effect of your own beside the catalogue, for this process: called, or as a decorator of its class.

    From then on it can be planted (`record`), it is fitted, chosen and reported by `explain` like any other, and
    `load_explained` reads results that name it. An effect of yours with the same name is replaced.

    Args:
        effect: your class, or an instance of it; see the page on writing an effect.
        robots: on which it is tried first; by default a leg with servos and a quadruped.

    Returns:
        What was given.

    Raises:
        InputError: a law that every effect obeys does not hold: places that exist, finite bounds, a sentence that names
            place and numbers, no change at neutral values, ...; or the program has an effect of that name.
    """
    one = effect() if isinstance(effect, type) else effect
    found = effect_faults(one)
    if not found:
        earlier = next((own for own in registry.own() if own.name == one.name), None)
        registry.register_effect(one)
        tried = robots or [Robot.from_xml(model_path(name)) for name in _TRIED]
        found = next((wrong for wrong in (effect_faults(one, robot) for robot in tried) if wrong), [])
        if found:
            registry.unregister(one.name)
            if earlier is not None:
                registry.register_effect(earlier)
    if found:
        raise InputError(found[0], where=f"the effect {type(one).__name__}", right="see docs/effects.md")
    return effect


def _row(e: Effect) -> tuple[str, ...]:
    parameters = ", ".join(f"{p.name} [{p.unit}]" if p.unit else p.name for p in e.parameters)
    return e.name, e.kind, e.side, parameters, e.equation
