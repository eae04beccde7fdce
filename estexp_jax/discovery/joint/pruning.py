"""What leaves a joint fit, and which of the model's values are findings.

Out goes what held-out stretches contradict, and values of the model that may as well be as the model has them.
"""

from __future__ import annotations

import numpy as np

from estexp_jax.discovery.joint.growth import Growth
from estexp_jax.discovery.joint.reading_stage import JointFit
from estexp_jax.estimation.parameters import Place
from estexp_jax.physics.effects.registry import effect


def needed(growth: Growth, fit: JointFit) -> tuple[Place, ...]:
    """The places of a fit without those that held-out stretches contradict, or that are the model's value after all."""
    as_modelled = _as_modelled(growth, fit)
    places = [p for p in fit.places if p not in as_modelled and growth.is_identifiable(p, fit.point)]
    held_out, base = growth.held_out(fit, [])
    groups = growth.groups(fit)
    base = np.setdiff1d(base, np.concatenate([np.zeros(0, int), *(groups[p] for p in {*fit.places} - {*places})]))

    def gain(place: Place) -> float:
        return held_out.gain_of(groups[place], base).in_errors

    weak = [p for p in places if gain(p) <= growth.criteria.kept_errors]
    while weak and gain(worst := min(weak, key=gain)) <= growth.criteria.kept_errors:
        weak.remove(worst)
        places.remove(worst)
        base = np.setdiff1d(base, groups[worst])
    return tuple(places)


def wrong_values(growth: Growth, fit: JointFit) -> tuple[Place, ...]:
    """Values of the model that the fit moved farther than they are usually off, where held-out stretches agree."""
    space, free = growth.objective.space, growth.free(fit)
    held_out, base = growth.held_out(fit, [])
    found = []
    for k, i in enumerate(free[len(free) - growth.n_nuisances(fit) :], len(free) - growth.n_nuisances(fit)):
        p = space.parameters[i]
        off = abs(fit.point[i] - p.neutral) / (growth.criteria.model_error * p.nominal)
        if off > growth.criteria.wrong_value and growth.is_gain(held_out.gain_of([k], base), 0.0):
            found.append(p.place)
    return tuple(found)


def _as_modelled(growth: Growth, fit: JointFit) -> list[Place]:
    """Values of the model whose interval holds what the model has: stretches do not agree that they are off."""
    space, std = growth.objective.space, dict(zip(fit.indices.tolist(), fit.std.tolist(), strict=True))
    found = []
    for place in fit.places:
        i = int(space.of_place[place][0])
        p = space.parameters[i]
        near = abs(fit.point[i] - p.neutral) <= growth.criteria.interval * std.get(i, 0.0)
        if p.nominal > 0.0 and effect(place[0]).model_attribute and near:
            found.append(place)
    return found
