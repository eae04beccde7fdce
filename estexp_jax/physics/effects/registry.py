"""Every effect by name: those of the package, and those that a user registers beside them.

The decorator `register_effect` puts an effect in; the folders `catalogue` and `laws` are loaded with this package. The
order is that of registering: so terms act, and so searches try them. Groups follow from what effects say of
themselves.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import TypeVar

from estexp_jax.errors import InputError, known
from estexp_jax.physics.effects.damage import Damage, ModelError
from estexp_jax.physics.effects.effect import Effect
from estexp_jax.physics.effects.logging_fault import LoggingFault

Catalogue = tuple[Effect, ...]
_E = TypeVar("_E", bound=Effect | type[Effect])

_EFFECTS: dict[str, Effect] = {}
_DAMAGED = ("controller", "actuator", "sensor", "environment", "joint", "body")
"""Kinds of elements in the order in which damages beyond the paper's are tried."""
_OFF = ("body", "actuator", "joint", "environment", "sensor", "controller")
"""Kinds of elements in the order in which errors of undamaged robots are drawn."""
_PACKAGE = f"{__name__.partition('.')[0]}."


def register_effect(effect: _E) -> _E:
    """Make an effect known, given as a class (then as a decorator) or an instance; the user's front door asks more.

    Raises:
        InputError: the package has one of that name. An effect of the user's own is replaced.
    """
    one = effect() if isinstance(effect, type) else effect
    there = _EFFECTS.get(one.name)
    if there is not None and not _is_own(there):
        raise InputError(f"there is an effect '{one.name}' already", right="call yours otherwise")
    _EFFECTS[one.name] = one
    return effect


def unregister(name: str) -> None:
    """Forget an effect of the user's own, if it is there."""
    if name in _EFFECTS and _is_own(_EFFECTS[name]):
        del _EFFECTS[name]


def every() -> Catalogue:
    """All effects, in the order in which terms act."""
    return tuple(_EFFECTS.values())


def named_effects() -> Catalogue:
    """The effects that have a name to be reported under, each in its first form: the catalogue."""
    return tuple(e for e in every() if e.named and e.claimable and not e.variant_of)


def variants() -> Catalogue:
    """Other forms of named effects, reported under their names."""
    return tuple(e for e in every() if e.variant_of or not e.claimable)


def nameless() -> Catalogue:
    """Unknown laws of other elements than joints: each is claimed as an effect is, not put together of terms."""
    return tuple(e for e in every() if e.tried_beside)


def logging_faults() -> tuple[LoggingFault, ...]:
    """What may go wrong when a log is written: decided before a search, and held by no simulation."""
    return tuple(e for e in every() if isinstance(e, LoggingFault))


def own() -> Catalogue:
    """The effects of the user's own."""
    return tuple(e for e in every() if _is_own(e))


def damages() -> tuple[Damage, ...]:
    """What recovery may choose from: the paper's six, in the order of its genome, then others by what they act on."""
    found = [e for e in every() if isinstance(e, Damage)]
    return (*paper(), *sorted((e for e in found if e.gene is None), key=lambda e: _DAMAGED.index(e.kind)))


def paper() -> tuple[Damage, ...]:
    """The six edits of the paper's estimation phase, in the order of its genome."""
    genes = {e.gene: e for e in every() if isinstance(e, Damage) and e.gene is not None}
    return tuple(genes[gene] for gene in sorted(genes))


def model_errors() -> tuple[ModelError, ...]:
    """The effects that change what simulators are a little wrong in, in the order in which errors are drawn."""
    found = [e for e in every() if isinstance(e, ModelError)]
    return tuple(sorted(found, key=lambda e: _OFF.index(e.kind)))


def effect(name: str) -> Effect:
    """The effect of that name.

    Raises:
        InputError: there is none; the message lists the catalogue.
    """
    if name not in _EFFECTS:
        raise InputError(f"there is no effect '{name}'", right=known(e.name for e in named_effects()))
    return _EFFECTS[name]


def catalogue(names: Iterable[str]) -> Catalogue:
    """The effects of those names, in that order."""
    return tuple(effect(name) for name in names)


def is_fixed(effect: Effect) -> bool:
    """Whether its name says what it does: it is this package's, and nothing was given to it when it was made."""
    return not (_is_own(effect) or vars(effect))


def _is_own(effect: Effect) -> bool:
    return not type(effect).__module__.startswith(_PACKAGE)
