"""Second stage: the choice refined on readings over longer windows, by Gauss-Newton steps with pruning and growth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.discovery.joint.candidates import derivatives, log_odds
from estexp_jax.discovery.joint.criteria import SelectionCriteria
from estexp_jax.estimation.linearised import Linearised, linearised, reading_noise_of
from estexp_jax.estimation.objective import Objective
from estexp_jax.estimation.parameters import ParameterSpace, Place
from estexp_jax.physics.effects.registry import effect
from estexp_jax.search.evidence import Posterior, SparseRegression

_SHARES = (1.0, 0.5, 0.25, 0.1)
"""Shares of a step that are tried, all at once."""


@final
@dataclass(frozen=True, eq=False)
class JointFit:
    """Effects fitted together, with small errors of the model's values.

    Attributes:
        point: of the parameter space.
        places: effects that are claimed.
        indices: (k,) parameters that were free, and `covariance` (k, k) of them.
        log_odds: of each place against its absence, nats.
        cost: mean squared residual on the fitted windows, in squares of `noise`.
        noise: (channels,) standard deviation of noise and model error.
    """

    point: np.ndarray
    places: tuple[Place, ...]
    indices: np.ndarray
    covariance: np.ndarray
    log_odds: dict[Place, float]
    cost: float
    noise: np.ndarray


def gauss_newton(
    objective: Objective,
    point: np.ndarray,
    places: Sequence[Place],
    nuisances: Sequence[int],
    least_noise: np.ndarray,
    criteria: SelectionCriteria,
) -> JointFit:
    """One step: relinearise, choose anew by evidence, and go as far as the residuals fall.

    Args:
        objective: the windows that are fitted.
        point: where to linearise.
        places: effects claimed so far.
        nuisances: indices of values of the model that may be a little off.
        least_noise: (channels,) noise of the readings.
        criteria: what decides.
    """
    space = objective.space
    own = [int(i) for place in places for i in space.of_place[place] if not space.parameters[i].categorical]
    free = derivatives(space, point, [*own, *nuisances])
    found = objective.responses(point, free.directions)
    noise = reading_noise_of(objective.dataset, found.point, least_noise, criteria.clip)
    linear = linearised(objective.dataset, found, noise, criteria.independent, criteria.clip)
    regression = _regression(space, linear, point, places, own, nuisances, free.steps, criteria)
    chosen = regression.pruned(range(len(places)))
    goal = _goal(space, point, places, own, nuisances, free.steps, chosen)
    new, cost = _line_search(objective, point, goal, noise, criteria)
    odds = {places[g]: value for g, value in regression.odds_of(chosen).items()}
    indices, covariance = _covariance(chosen, free.indices, free.steps)
    return JointFit(new, tuple(odds), indices, covariance, odds, cost, noise)


def _regression(
    space: ParameterSpace,
    linear: Linearised,
    point: np.ndarray,
    places: Sequence[Place],
    own: Sequence[int],
    nuisances: Sequence[int],
    steps: np.ndarray,
    criteria: SelectionCriteria,
) -> SparseRegression:
    """Unknowns are whole differences from neutral, in units of steps or directions, so that each can go to nothing."""
    n_own, n_free = len(own), len(own) + len(nuisances)
    free = np.array([*own, *nuisances], dtype=int)
    offset = (point - space.neutral)[free] / steps if n_free else np.zeros(0)
    errors = np.array([criteria.model_error * space.parameters[i].nominal for i in nuisances])
    both = np.isin(free[n_own:], free[:n_own])  # a claimed value of the model is no nuisance besides
    r = linear.residual + linear.columns[:, :n_free] @ np.where(np.r_[np.zeros(n_own, bool), both], 0.0, offset)
    precision = np.zeros(linear.columns.shape[1])
    precision[n_own:n_free] = np.where(both, 1e12, (steps[n_own:] / errors) ** 2)
    low, high = np.full(len(precision), -np.inf), np.full(len(precision), np.inf)
    groups = [np.flatnonzero(np.isin(own, space.of_place[place])) for place in places]
    for group in groups:  # the first number of an effect is its amount: of one sign where it cannot have two
        for k in group[:1]:
            p = space.parameters[own[k]]
            if p.neutral <= space.bounds[own[k], 0]:
                low[k], high[k] = (0.0, np.inf) if steps[k] > 0.0 else (-np.inf, 0.0)
    numbers = np.array([len(effect(name).parameters) for name, _ in places], dtype=float)
    return SparseRegression(
        linear.columns.T @ linear.columns,
        linear.columns.T @ r,
        linear.observations,
        precision,
        groups,
        range(len(places)),
        low,
        high,
        numbers,
        log_odds(places, criteria, len(space.of_place)),
    )


def _goal(
    space: ParameterSpace,
    point: np.ndarray,
    places: Sequence[Place],
    own: Sequence[int],
    nuisances: Sequence[int],
    steps: np.ndarray,
    chosen: Posterior,
) -> np.ndarray:
    """The point that the regression leads to."""
    times = chosen.coefficients(len(steps))
    goal = space.neutral.copy()
    for k, i in enumerate([*own, *nuisances]):
        goal[i] += times[k] * steps[k]
    for g, place in enumerate(places):
        fixed = [i for i in space.of_place[place] if space.parameters[i].categorical]
        goal[fixed] = point[fixed]
        if g not in chosen.groups:
            goal[[i for i in space.of_place[place] if i not in nuisances]] = space.neutral[
                [i for i in space.of_place[place] if i not in nuisances]
            ]
    return _inside(space, goal)


def _inside(space: ParameterSpace, point: np.ndarray) -> np.ndarray:
    """The point with ratios within their bounds, and amounts on their side of nothing."""
    found = point.copy()
    for i in np.flatnonzero(found != space.neutral):
        p, (low, high) = space.parameters[i], space.bounds[i]
        unit = next(q.unit for q in effect(p.effect).parameters if q.name == p.name)
        found[i] = np.clip(found[i], low, high if not unit else max(high, found[i]))
    return found


def _line_search(
    objective: Objective, point: np.ndarray, goal: np.ndarray, noise: np.ndarray, criteria: SelectionCriteria
) -> tuple[np.ndarray, float]:
    """The best point on the way to a goal, with its cost; what comes or goes does so at once."""
    space = objective.space
    at_once = (point == space.neutral) | (goal == space.neutral) | [p.categorical for p in space.parameters]
    begin = np.where(at_once, goal, point)
    tried = np.array([begin + share * (goal - begin) for share in _SHARES])
    simulated = objective.simulate(tried)
    left = (objective.dataset.measurements - simulated) / noise
    bounded = np.clip(left, -10.0 * criteria.clip, 10.0 * criteria.clip)
    bounded = np.where(np.isnan(simulated) & np.isfinite(objective.dataset.measurements), 10.0 * criteria.clip, bounded)
    costs = np.nanmean(bounded**2, axis=(1, 2, 3))
    best = int(np.argmin(costs))
    return tried[best], float(costs[best])


def _covariance(chosen: Posterior, indices: np.ndarray, steps: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Free parameters of the choice and their covariance, in their units."""
    known = chosen.columns < len(indices)
    rows = chosen.columns[known]
    scale = steps[rows]
    return indices[rows], chosen.covariance[np.ix_(known, known)] * np.outer(scale, scale)
