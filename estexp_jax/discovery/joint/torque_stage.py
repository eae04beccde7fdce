"""First stage: which effects, of all at once, account for the torques that short windows lack."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.discovery.joint.candidates import Candidate, log_odds
from estexp_jax.discovery.joint.criteria import SelectionCriteria
from estexp_jax.estimation.objective import Objective
from estexp_jax.estimation.parameters import ParameterSpace, Place
from estexp_jax.estimation.torque_balance import TorqueBalance, torque_balance
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot
from estexp_jax.search.sparse_regression import Posterior, SparseRegression

_RIDGE = 1e-3
"""Of the first, dense fit, as a share of each column's size."""


@final
@dataclass(frozen=True, eq=False)
class TorqueChoice:
    """Effects that account for lacking torques.

    Attributes:
        point: of the parameter space, with the effects' values.
        places: of the effects.
        shares: root mean square torque of each, as a share of its joint's.
        noise: (nv,) standard deviation of what remains, as a share of each joint's torque.
    """

    point: np.ndarray
    places: tuple[Place, ...]
    shares: dict[Place, float]
    noise: np.ndarray


def torque_choices(
    objective: Objective,
    tried: Sequence[Candidate],
    nuisances: Sequence[int],
    robots: Sequence[Robot],
    criteria: SelectionCriteria,
) -> list[TorqueChoice]:
    """Choose effects by the torque balance of short windows: among those that add torque, and among all.

    With values that scale torques there are two: a balance in which nothing acts has little to lack, so that the
    readings have to decide.

    Args:
        objective: its windows are short, its outputs states.
        tried: what may be chosen.
        nuisances: indices of the parameters that may be a little off beside it.
        robots: the nominal robot with each recording's settings.
        criteria: what decides.
    """
    space = objective.space
    directions = np.concatenate([[c.direction for c in tried], _errors(space, nuisances, criteria)])
    balance = torque_balance(objective, space.neutral, directions, robots)
    felt = [c for c in range(len(tried)) if _is_felt(balance, c, criteria)]
    adding = [c for c in felt if effect(tried[c].place[0]).additive]
    offered = [adding, felt] if len(felt) > len(adding) else [felt]
    return [_choice(objective, balance, tried, kept, criteria) for kept in offered]


def _choice(
    objective: Objective,
    balance: TorqueBalance,
    tried: Sequence[Candidate],
    kept: Sequence[int],
    criteria: SelectionCriteria,
) -> TorqueChoice:
    """The choice among some of what is tried."""
    space = objective.space
    columns = np.concatenate([balance.columns[list(kept)], balance.columns[len(tried) :]])
    own = [tried[c] for c in kept]
    std = _noise(_densely_explained(balance, columns, own, criteria), balance, objective.dataset.owner, criteria)
    regression = _regression(balance, columns, std, own, criteria, space.robot)
    simple = {g for g, c in enumerate(own) if _is_simple(c)}
    chosen = regression.search(allowed=simple)
    chosen = _without_trifles(regression, chosen, balance, columns, criteria)
    times = chosen.coefficients(len(columns))
    point, shares = space.neutral.copy(), dict[Place, float]()
    for g in sorted(chosen.groups):
        point += own[g].at(times[g])
        shares[own[g].place] = _share(times[g] * columns[g], balance)
    return TorqueChoice(point, tuple(shares), shares, std / balance.scale)


def _is_simple(candidate: Candidate) -> bool:
    """Whether a balance can tell it: relatives of friction look alike; what contains a constant torque does not."""
    nested = effect(candidate.place[0]).nested_in
    return not nested or effect(nested).is_constant_torque


def _errors(space: ParameterSpace, nuisances: Sequence[int], criteria: SelectionCriteria) -> np.ndarray:
    """Directions (nuisances, n): each value of the model off by an ordinary error."""
    found = np.zeros((len(nuisances), len(space.parameters)))
    for row, i in enumerate(nuisances):
        found[row, i] = criteria.model_error * space.parameters[i].nominal
    return found


def _share(torque: np.ndarray, balance: TorqueBalance) -> float:
    return float(np.sqrt(np.max(np.mean(torque**2, axis=0) / balance.scale**2)))


def _is_felt(balance: TorqueBalance, c: int, criteria: SelectionCriteria) -> bool:
    """Whether a direction adds torque at all: what does not act in short windows cannot be told by them."""
    share = _share(balance.columns[c], balance)
    return bool(np.isfinite(share)) and share > 1e-3 * criteria.least_share


def _regression(
    balance: TorqueBalance,
    columns: np.ndarray,
    std: np.ndarray,
    own: Sequence[Candidate],
    criteria: SelectionCriteria,
    robot: Robot,
) -> SparseRegression:
    weight = 1.0 / np.sqrt(std**2 + balance.noise**2)
    j = (columns * weight).reshape(len(columns), -1).T
    r = (balance.lacking * weight).ravel()
    slots = {place: i for i, place in enumerate(dict.fromkeys(c.place for c in own))}
    rest = len(columns) - len(own)
    return SparseRegression(
        j.T @ j,
        j.T @ r,
        float(len(r)),
        np.concatenate([np.zeros(len(own)), np.ones(rest)]),
        [np.array([g]) for g in range(len(own))],
        [slots[c.place] for c in own],
        np.concatenate([[c.least for c in own], np.full(rest, -np.inf)]),
        np.concatenate([[c.most for c in own], np.full(rest, np.inf)]),
        np.array([c.numbers for c in own]),
        log_odds([c.place for c in own], criteria, robot),
    )


def _without_trifles(
    regression: SparseRegression, chosen: Posterior, balance: TorqueBalance, columns: np.ndarray, c: SelectionCriteria
) -> Posterior:
    """The choice without effects that are smaller than what no simulator gets right, the smallest first."""
    while chosen.groups:
        times = chosen.coefficients(len(columns))
        shares = {g: _share(times[g] * columns[g], balance) for g in chosen.groups}
        least = min(shares, key=lambda g: shares[g])
        if shares[least] >= c.least_share:
            break
        chosen = regression.pruned(chosen.groups - {least})
    return chosen


def _densely_explained(
    balance: TorqueBalance, columns: np.ndarray, own: Sequence[Candidate], criteria: SelectionCriteria
) -> np.ndarray:
    """What remains of lacking torques (windows, nv) once one guess of every place is fitted, by ridge regression."""
    places = [c.place for c in own]
    first = [places.index(p) for p in dict.fromkeys(places)] + list(range(len(own), len(columns)))
    weight = 1.0 / np.maximum(criteria.torque_floor * balance.scale, balance.noise)
    j = (columns[first] * weight).reshape(len(first), -1).T
    size = np.sqrt(np.mean(j**2, axis=0)) + 1e-300
    normal = (j / size).T @ (j / size) + _RIDGE * len(j) * np.eye(j.shape[1])
    times = np.linalg.solve(normal, (j / size).T @ (balance.lacking * weight).ravel()) / size
    return balance.lacking - np.einsum("k,kwi->wi", times, columns[first])


def _noise(left: np.ndarray, balance: TorqueBalance, owner: np.ndarray, criteria: SelectionCriteria) -> np.ndarray:
    """Standard deviation (nv,) of what remains, larger where it lasts from window to window: so many are one datum."""
    usual = np.median(np.abs(left), axis=0) / 0.6745
    std = np.sqrt(np.mean(np.clip(left, -criteria.clip * usual, criteria.clip * usual) ** 2, axis=0))
    same = owner[1:] == owner[:-1]
    a, b = left[1:][same], left[:-1][same]
    size = np.sqrt(np.mean(a**2, axis=0) * np.mean(b**2, axis=0))
    rho = np.clip(np.mean(a * b, axis=0) / np.maximum(size, 1e-300), 0.0, 0.95)
    return np.maximum(std * np.sqrt((1.0 + rho) / (1.0 - rho)), criteria.torque_floor * balance.scale)
