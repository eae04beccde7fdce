"""The held-out rule: what gains in all stretches, and what gains in one at the cost of others."""

import numpy as np
import pytest

from estexp_jax.discovery.joint.held_out import HeldOut, HeldOutGain
from estexp_jax.estimation.linearised import Linearised

WINDOWS, ROWS, BASE = 32, 20, np.array([0, 1])


def _held_out(columns: np.ndarray, target: np.ndarray) -> HeldOut:
    window = np.repeat(np.arange(WINDOWS), ROWS)
    linear = Linearised(target, columns, 1.0, 2.0 * WINDOWS, window)
    scale = np.sqrt(2.0 / ROWS)  # two independent data a window
    linear = linear._replace(columns=columns * scale, residual=target * scale)
    return HeldOut(linear, target * scale, np.zeros(columns.shape[1]), 8, 2.0, 4.0)


@pytest.fixture
def data() -> tuple[np.ndarray, np.ndarray]:
    """Columns (data, 4) and what the first three of them add up to with noise; the fourth does nothing."""
    rng = np.random.default_rng(0)
    columns = rng.standard_normal((WINDOWS * ROWS, 4))
    return columns, columns[:, :3] @ [1.0, -2.0, 1.5] + 0.5 * rng.standard_normal(len(columns))


def test_what_is_at_work_gains_and_what_is_not_does_not(data: tuple[np.ndarray, np.ndarray]):
    free = np.full(2, np.inf)
    there, nothing = _held_out(*data).gains_of([2, 3], BASE, np.zeros(0, int), -free, free)
    assert there.in_errors > 5.0
    assert there.coefficient == pytest.approx(1.5, abs=0.1)
    assert nothing.total < 0.5


def test_a_column_in_place_of_another_is_judged_against_both(data: tuple[np.ndarray, np.ndarray]):
    free = np.full(1, np.inf)
    held_out = _held_out(*data)
    [worse] = held_out.gains_of([3], np.array([0, 1, 2]), np.array([2]), -free, free)
    [better] = held_out.gains_of([2], np.array([0, 1, 3]), np.array([3]), -free, free)
    assert worse.total < 0.0 < better.total


def test_a_coefficient_stays_within_its_bounds(data: tuple[np.ndarray, np.ndarray]):
    [found] = _held_out(*data).gains_of([2], BASE, np.zeros(0, int), np.array([0.0]), np.array([0.5]))
    assert found.coefficient == 0.5


def test_a_gain_in_one_stretch_alone_is_within_its_error(data: tuple[np.ndarray, np.ndarray]):
    columns, _ = data
    rng = np.random.default_rng(1)
    target = columns[:, :2] @ [1.0, -2.0] + 0.5 * rng.standard_normal(len(columns))
    target[: 2 * ROWS] += 20.0 * columns[: 2 * ROWS, 3]  # two windows of one stretch
    gain = _held_out(columns, target).gain_of([3], BASE)
    assert gain.in_errors < 2.0


def test_leaving_a_needed_column_out_costs(data: tuple[np.ndarray, np.ndarray]):
    held_out = _held_out(*data)
    assert held_out.gain_of([1], np.array([0, 1, 2])).in_errors > 5.0
    assert held_out.gain_of([3], np.array([0, 1, 2, 3])).total < 0.5


def test_one_more_column_is_the_same_as_a_group_of_one(data: tuple[np.ndarray, np.ndarray]):
    held_out, free = _held_out(*data), np.full(1, np.inf)
    [one] = held_out.gains_of([2], BASE, np.zeros(0, int), -free, free)
    group = held_out.gain_of([2], BASE)
    assert (one.total, one.standard_error) == pytest.approx((group.total, group.standard_error), rel=1e-6)


def test_of_few_stretches_less_of_a_gain_is_beyond_chance():
    few, many = HeldOutGain(10.0, 4.0, 1.0, 3), HeldOutGain(10.0, 4.0, 1.0, 200)
    assert few.least(0.05) < 0.0 < many.least(0.05) < 10.0
    assert many.least(0.05) == pytest.approx(10.0 - 1.645 * 4.0, abs=0.1)
