"""What leaves a joint fit that held-out stretches contradict, and which of the model's values are findings."""

from __future__ import annotations

import numpy as np

from estexp_jax.discovery.joint.growth import Growth
from estexp_jax.discovery.joint.reading_stage import JointFit
from estexp_jax.estimation.parameters import Place


def needed(growth: Growth, fit: JointFit) -> tuple[Place, ...]:
    """The places of a fit without those that held-out stretches contradict."""
    places = [p for p in fit.places if growth.is_identifiable(p, fit.point)]
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
