"""Laws of what effects answer searches: relatives that exist, initial guesses within reason."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from estexp_jax.physics.effects.effect import Effect
from estexp_jax.physics.effects.guesses import Vectors
from estexp_jax.physics.effects.observed import Observed
from estexp_jax.physics.effects.registry import effect, every
from estexp_jax.physics.model.robot import Robot

_RELATIONS = ("nested_in", "variant_of", "tried_beside", "family", "alike_while_on")
_SEEN = (-0.5, 0.7)
"""Positions, rad or m, between which joints are taken to have moved."""


def relation_faults(e: Effect) -> Iterator[str]:
    """What is wrong with the effects that it names as its relatives, a clause each."""
    names = {other.name for other in every()} - {e.name}
    for relation in _RELATIONS:
        other = getattr(e, relation)
        if other and other not in names:
            yield f"names '{other}' in {relation}, which is no other effect"
        elif other and relation == "nested_in" and _is_above(e, effect(other)):
            yield f"is nested in '{other}', which is nested in it"


def guess_faults(e: Effect, robot: Robot) -> Iterator[str]:
    """What is wrong with the values from which searches for it start, a clause each."""
    nq, n = robot.model.nq, robot.model.nsensordata
    observed = Observed(np.full(nq, _SEEN[0]), np.full(nq, _SEEN[1]), np.full(n, 0.1))
    for site in e.sites(robot):
        if e.claimable and e.kind != "controller" and (e.named or e.tried_beside):
            yield from _vectors(e, e.initial_guesses(robot, site, observed), f"starts a search at '{site}'")
        if e.nested_in:
            simpler = effect(e.nested_in)
            known, own = ({p.name: 0.5 for p in x.parameters} for x in (simpler, e))
            climbed = e.from_simpler(known, e.bounds(robot, site))
            yield from _vectors(e, climbed, f"starts from '{simpler.name}' at '{site}'")
            yield from _vectors(simpler, e.to_simpler(own), f"gives '{simpler.name}' at '{site}' to start")


def _is_above(e: Effect, other: Effect) -> bool:
    """Whether an effect is a simpler relative of another one."""
    while other.nested_in and other.nested_in != e.name:
        other = effect(other.nested_in)
    return bool(other.nested_in)


def _vectors(e: Effect, found: Vectors, what: str) -> Iterator[str]:
    neutral = tuple(p.neutral for p in e.parameters)
    for values in found:
        if len(values) != len(neutral) or not np.isfinite(values).all():
            yield f"{what} from {values}; a finite number for each parameter is wanted"
            return
        if tuple(values) == neutral:
            yield f"{what} from its neutral values, where it is absent"
            return
