"""Whitening of windows about a point."""

import numpy as np
import pytest

from estexp_jax.estimation.channels import Channels
from estexp_jax.estimation.dataset import Dataset
from estexp_jax.estimation.linearised import linearised, reading_noise_of
from estexp_jax.estimation.objective import Responses


@pytest.fixture
def data(monkeypatch: pytest.MonkeyPatch) -> Dataset:
    found = Dataset((), Channels(("q",), np.array([0]), np.zeros(0, int)), ())
    measured = np.random.default_rng(0).standard_normal((3, 20, 1))
    monkeypatch.setattr(Dataset, "measurements", measured)
    monkeypatch.setattr(Dataset, "durations", np.full(3, 0.5))
    return found


def _responses(data: Dataset, start: np.ndarray) -> Responses:
    shape = data.measurements.shape
    return Responses(np.zeros(shape), np.ones((2, *shape)), np.broadcast_to(start, (1, *shape)))


def test_a_window_counts_as_few_independent_data(data: Dataset):
    found = linearised(data, _responses(data, np.zeros((20, 1))), np.ones(1), 0.25, 3.0)
    assert found.observations == 6.0
    assert np.isclose(np.sum(found.residual**2), 2.0 / 20.0 * np.sum(data.measurements**2))


def test_what_another_start_would_explain_counts_little(data: Dataset):
    ramp = 50.0 * np.linspace(0.0, 1.0, 20)[:, None]
    data.measurements[:] = ramp
    free = linearised(data, _responses(data, np.zeros((20, 1))), np.ones(1), 0.25, 1e9)
    doubted = linearised(data, _responses(data, ramp), np.ones(1), 0.25, 1e9)
    assert np.sum(doubted.residual**2) < 0.02 * np.sum(free.residual**2)


def test_noise_is_what_is_left_but_at_least_that_of_the_readings(data: Dataset):
    measured = data.measurements
    assert np.allclose(reading_noise_of(data, measured, np.array([0.1]), 3.0), 0.1)
    assert np.allclose(reading_noise_of(data, measured + 0.5, np.array([0.1]), 3.0), 0.5)


def test_products_of_whitened_columns_are_those_with_the_inverse_covariance(data: Dataset):
    rng = np.random.default_rng(1)
    shape = data.measurements.shape
    start = rng.standard_normal((4, *shape))
    responses = Responses(np.zeros(shape), rng.standard_normal((2, *shape)), start)
    found = linearised(data, responses, np.ones(1), 0.25, 1e9)
    own, spread = responses.change[:, 0, :, 0].T, start[:, 0, :, 0].T
    covariance = 10.0 * np.eye(20) + spread @ spread.T  # twenty rows that count as two
    columns = found.columns[found.window == 0]
    np.testing.assert_allclose(columns.T @ columns, own.T @ np.linalg.solve(covariance, own), rtol=1e-9)
