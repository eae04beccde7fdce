"""Second stage: the choice refined on readings over longer windows, by Gauss-Newton steps with pruning and growth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from estexp_jax.discovery.joint.candidates import Derivatives, derivatives, log_odds
from estexp_jax.discovery.joint.criteria import SelectionCriteria
from estexp_jax.estimation.linearised import Linearised, linearised, reading_noise_of
from estexp_jax.estimation.objective import Objective
from estexp_jax.estimation.parameters import ParameterSpace, Place
from estexp_jax.physics.effects.registry import effect
from estexp_jax.search.sparse_regression import Posterior, SparseRegression

STRETCHES = 16
"""Stretches that the windows are divided into to see how far they disagree."""
_RIDGE = 1e-9
"""Precision of a free column in a part of the data, as a share of what all say of it."""
_SHARES = (1.0, 0.5, 0.25, 0.1)
"""Shares of a step that are tried, all at once."""


@final
@dataclass(frozen=True, eq=False)
class JointFit:
    """Effects fitted together, with small errors of the model's values.

    Attributes:
        point: of the parameter space.
        places: effects that are claimed.
        indices: (k,) parameters that were free, and `covariance` (k, k) of them, as the noise model has it.
        std: (k,) standard deviations, where larger those by which stretches of the recordings disagree.
        log_odds: of each place against its absence, nats.
        cost: mean squared residual on the fitted windows, in squares of `noise`.
        noise: (channels,) standard deviation of noise and model error.
    """

    point: np.ndarray
    places: tuple[Place, ...]
    indices: np.ndarray
    covariance: np.ndarray
    std: np.ndarray
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
    *,
    prune: bool = True,
) -> JointFit:
    """One step: relinearise, choose anew by evidence, and go as far as the residuals fall.

    Args:
        objective: the windows that are fitted, without the error of the simulator's step.
        point: where to linearise.
        places: effects claimed so far.
        nuisances: indices of values of the model that may be a little off.
        least_noise: (channels,) noise of the readings.
        criteria: what decides.
        prune: whether effects go that evidence speaks against.
    """
    space = objective.space
    own = [int(i) for place in places for i in space.of_place[place]]
    errors = [i for i in nuisances if i not in own]  # a claimed value of the model is no nuisance besides
    free = derivatives(space, point, [*own, *errors])
    found = objective.responses(point, free.directions)
    noise = reading_noise_of(objective.dataset, found.point, least_noise, criteria.clip)
    linear = linearised(objective.dataset, found, noise, criteria.correlation_time, criteria.clip)
    offset = (point - space.neutral)[free.indices] / free.steps
    regression = _regression(space, linear, offset, places, free, criteria)
    chosen = regression.pruned(range(len(places))) if prune else regression.posterior(range(len(places)))
    goal = space.neutral.copy()
    goal[free.indices] += chosen.coefficients(len(free.steps)) * free.steps
    new, cost = _line_search(objective, point, within_bounds(space, goal), noise, criteria)
    odds = {places[g]: value for g, value in regression.odds_of(chosen).items()}
    scale = free.steps[chosen.columns]
    covariance = chosen.covariance * np.outer(scale, scale)
    spread = np.abs(scale) * _jackknife(regression, linear, chosen, offset)
    std = np.maximum(spread, np.sqrt(np.diag(covariance)))
    return JointFit(new, tuple(odds), free.indices[chosen.columns], covariance, std, odds, cost, noise)


def _regression(
    space: ParameterSpace,
    linear: Linearised,
    offset: np.ndarray,
    places: Sequence[Place],
    free: Derivatives,
    criteria: SelectionCriteria,
) -> SparseRegression:
    """Unknowns are whole differences from neutral, in steps, so that each effect can go to nothing.

    Args:
        space: of the parameters.
        linear: about a point, along the steps of `free`.
        offset: (k,) of the point from neutral, in steps.
        places: effects claimed.
        free: the parameters; those of no place are values of the model that may be a little off.
        criteria: what decides.
    """
    groups = [np.flatnonzero(np.isin(free.indices, space.of_place[place])) for place in places]
    claimed = np.isin(np.arange(len(free.indices)), np.concatenate([np.zeros(0, int), *groups]))
    nominal = np.array([space.parameters[i].nominal for i in free.indices])
    error = np.where(claimed, np.inf, criteria.model_error * nominal)
    low, high = np.full(len(claimed), -np.inf), np.full(len(claimed), np.inf)
    for k in (int(group[0]) for group in groups):  # an effect's first number is its amount, which may have one sign
        i = int(free.indices[k])
        if space.parameters[i].neutral <= space.bounds[i, 0]:
            low[k], high[k] = (0.0, np.inf) if free.steps[k] > 0.0 else (-np.inf, 0.0)
    return SparseRegression(
        linear.columns.T @ linear.columns,
        linear.columns.T @ (linear.residual + linear.columns @ offset),
        linear.observations,
        (free.steps / error) ** 2,
        groups,
        range(len(places)),
        low,
        high,
        np.array([len(effect(name).parameters) for name, _ in places], dtype=float),
        log_odds(places, criteria, space.robot, space.of_place, places),
    )


def within_bounds(space: ParameterSpace, point: np.ndarray) -> np.ndarray:
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
    """The best point on the way to a goal, with its cost; what comes or goes does so at once, or the point itself."""
    space = objective.space
    at_once = (point == space.neutral) | (goal == space.neutral) | [p.categorical for p in space.parameters]
    begin = np.where(at_once, goal, point)
    tried = np.array([*(begin + share * (goal - begin) for share in _SHARES), point])
    costs = cost_at(objective, tried, noise, criteria)
    best = int(np.argmin(costs))
    return tried[best], float(costs[best])


def without(space: ParameterSpace, fit: JointFit, places: Sequence[Place]) -> np.ndarray:
    """The point (n,) at which some effects are absent and all else is as the joint fit's covariance has it then."""
    point = fit.point.copy()
    gone = np.isin(fit.indices, [i for place in places for i in space.of_place[place]])
    if gone.any():
        offset = (fit.point - space.neutral)[fit.indices]
        gain = np.linalg.lstsq(fit.covariance[np.ix_(gone, gone)], offset[gone], rcond=None)[0]
        point[fit.indices[~gone]] -= fit.covariance[np.ix_(~gone, gone)] @ gain
        point = np.clip(point, space.bounds[:, 0], np.maximum(space.bounds[:, 1], point))
    for place in places:
        point[space.of_place[place]] = space.neutral[space.of_place[place]]
    return point


def cost_at(objective: Objective, points: np.ndarray, noise: np.ndarray, criteria: SelectionCriteria) -> np.ndarray:
    """Mean squared residuals (points,) at points (points, n), in squares of `noise` (channels,), each bounded."""
    simulated, measured = objective.simulate(points), objective.dataset.measurements
    most = 10.0 * criteria.clip
    bounded = np.clip((measured - simulated) / noise, -most, most)
    bounded = np.where(np.isnan(simulated) & np.isfinite(measured), most, bounded)
    return np.nanmean(bounded**2, axis=(1, 2, 3))


def _jackknife(regression: SparseRegression, linear: Linearised, chosen: Posterior, offset: np.ndarray) -> np.ndarray:
    """Standard deviations (k,) of the chosen columns' coefficients, each stretch of the windows left out in turn.

    What the model still lacks differs from stretch to stretch, which no formula for independent noise knows of.

    Source: Efron and Stein, Annals of Statistics 9 (1981), the jackknife estimate of variance.
    """
    windows = np.unique(linear.window)
    n = min(STRETCHES, len(windows))
    if n < 2:
        return np.zeros(len(chosen.columns))
    r, found = linear.residual + linear.columns @ offset, []
    ridge = _RIDGE * np.diag(np.diag(regression.matrix))  # a column may be at work in the stretch alone
    for part in np.array_split(windows, n):
        own = np.isin(linear.window, part)
        j = linear.columns[own]
        rest = replace(regression, matrix=regression.matrix + ridge - j.T @ j, vector=regression.vector - j.T @ r[own])
        found.append(rest.posterior(chosen.groups).mean)
    return np.sqrt((n - 1) / n * np.sum((np.array(found) - np.mean(found, axis=0)) ** 2, axis=0))
