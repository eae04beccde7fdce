"""Sparse regression by evidence, on data whose truth is known."""

from dataclasses import replace
from typing import Any

import numpy as np

from estexp_jax.search.sparse_regression import SparseRegression


def _regression(j: np.ndarray, r: np.ndarray, **changed: Any) -> SparseRegression:
    n = j.shape[1]
    plain = SparseRegression(
        matrix=j.T @ j,
        vector=j.T @ r,
        observations=float(len(r)),
        precision=np.zeros(n),
        groups=[np.array([k]) for k in range(n)],
        slots=list(range(n)),
        low=np.full(n, -np.inf),
        high=np.full(n, np.inf),
        n_parameters=np.ones(n),
        log_odds=np.full(n, -2.0),
    )
    return replace(plain, **changed)


def _data(seed: int = 0, n: int = 30) -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(seed)
    j = rng.standard_normal((400, n))
    j[:, 1] = j[:, 0] + 0.3 * rng.standard_normal(400)  # two that look alike
    return j, 2.0 * j[:, 0] - 1.0 * j[:, 5] + 0.5 * j[:, 7] + rng.standard_normal(400)


def test_exactly_the_columns_at_work_are_chosen():
    j, r = _data()
    found = _regression(j, r).search()
    assert found.groups == {0, 5, 7}
    truth = np.zeros(30)
    truth[[0, 5, 7]] = 2.0, -1.0, 0.5
    assert np.abs(found.coefficients(30) - truth).max() < 0.2


def test_noise_alone_chooses_nothing():
    rng = np.random.default_rng(1)
    chosen = [_regression(rng.standard_normal((400, 60)), rng.standard_normal(400)).search().groups for _ in range(20)]
    assert sum(map(len, chosen)) <= 1


def test_a_wrong_start_is_exchanged():
    j, r = _data()
    assert _regression(j, r).search({1}).groups == {0, 5, 7}


def test_without_exchange_a_start_stays():
    j, r = _data()
    assert 5 not in _regression(j, r).search({1}, allowed={7}, exchange=False).groups


def test_a_coefficient_beyond_its_bounds_is_not_chosen():
    j, r = _data()
    assert 5 not in _regression(j, r, low=np.zeros(30)).search().groups


def test_of_one_slot_at_most_one_group_is_chosen():
    j, r = _data()
    slots = [0 if k in (0, 5) else k for k in range(30)]
    assert len(_regression(j, r, slots=slots).search().groups & {0, 5}) == 1


def test_nuisances_take_up_what_their_prior_allows():
    j, r = _data()
    precision = np.zeros(30)
    precision[0] = 1e-4
    found = _regression(j, r, precision=precision, groups=[np.array([k]) for k in range(1, 30)], slots=list(range(29)),
                        n_parameters=np.ones(29), log_odds=np.full(29, -2.0)).search()  # fmt: skip
    assert found.groups == {4, 6}  # columns 5 and 7
    assert abs(found.coefficients(30)[0] - 2.0) < 0.2


def test_gains_are_what_adding_a_group_gives():
    j, r = _data()
    regression = _regression(j, r)
    at = regression.posterior({5})
    gains = regression.gains(at)
    for g in (0, 7, 12):
        assert np.isclose(gains[g], regression.posterior({5, g}).log_evidence - at.log_evidence, rtol=1e-4, atol=1e-4)
    assert gains[5] == -np.inf
