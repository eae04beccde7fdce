"""Costs of differences against their equations written out."""

import numpy as np
import pytest

from estexp_jax.recovery.estimation.error_model import (
    _FLOOR,
    _SHARE,
    _TOLERANCE,
    ErrorModel,
    angle_cost,
    angle_deviations,
    linearise_errors_at,
    touch_cost,
)
from estexp_jax.recovery.model_error import ANGLE_NOISE, FLIP_PROBABILITY

TOUCH = np.array([True, False, False])


@pytest.fixture(scope="module")
def readings() -> np.ndarray:
    """(1 + members, trials, rows, n_inputs) = (6, 2, 7, 3); the first member has one touch flipped."""
    draw = np.random.default_rng(7)
    angles = 0.1 * draw.standard_normal((1, 2, 7, 2)) + 0.02 * draw.standard_normal((6, 2, 7, 2))
    touch = np.ones((6, 2, 7, 1))
    touch[1, 0, 3] = -1.0
    return np.concatenate([touch, angles], axis=3)


@pytest.fixture(scope="module")
def model(readings: np.ndarray) -> ErrorModel:
    return linearise_errors_at(readings, TOUCH, np.zeros((5, 0)))


def test_a_difference_of_angles_costs_as_the_equation_says(readings: np.ndarray, model: ErrorModel) -> None:
    x = (readings[1:] - readings[0])[..., 1:].reshape(5, -1) / np.sqrt(5)
    v = np.diag(ANGLE_NOISE**2 + _FLOOR**2 + _SHARE**2 * np.sum(x**2, axis=0))
    errors = 0.05 * np.random.default_rng(8).standard_normal((4, x.shape[1]))
    expected = [error @ np.linalg.solve(v + x.T @ x, error) for error in errors]
    np.testing.assert_allclose(angle_cost(model, errors), expected, rtol=1e-9)
    assert model.log_det == pytest.approx(np.linalg.slogdet(v + x.T @ x)[1])


def test_a_flip_costs_less_where_the_ensemble_is_unsure(readings: np.ndarray, model: ErrorModel) -> None:
    measured = readings[0][..., TOUCH]
    flips = np.stack([measured, measured, measured])
    flips[1, 0, 3] *= -1.0
    flips[2, 0, 4] *= -1.0
    unsure, sure = FLIP_PROBABILITY + 0.2, FLIP_PROBABILITY
    expected = [0.0, *(2.0 * np.log((1.0 - p) / p) for p in (unsure, sure))]
    np.testing.assert_allclose(touch_cost(model, measured, flips), expected, rtol=1e-9, atol=1e-12)


def test_a_level_that_is_off_costs_its_logarithm(readings: np.ndarray, model: ErrorModel) -> None:
    measured = readings[0][..., TOUCH]
    level = measured.copy()
    level[1, 2] = 1.0 - 3.0 * _TOLERANCE
    assert touch_cost(model, measured, level[None]) == pytest.approx([np.log(10.0)])


def test_a_simulation_that_diverged_says_nothing(readings: np.ndarray) -> None:
    diverged = readings.copy()
    diverged[2, 0, 5, 1] = np.nan
    found = angle_deviations(diverged, TOUCH, np.ones((5, 2)))
    assert found.shape == (5, 2 + 28)
    assert not found[1, 2:].any() and np.all(found[[0, 2, 3, 4], 2:] != 0.0)
    assert np.all(found[:, :2] == 1.0)
