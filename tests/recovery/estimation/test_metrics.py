"""The paper's metrics against their equations written out."""

import numpy as np
import pytest

from estexp_jax.recovery.estimation.metrics import distance_error, rolling_mean


def equation_2(physical: np.ndarray, simulated: np.ndarray, h: int, w: int) -> float:
    c, _, n = physical.shape
    total = 0.0
    for i in range(c):
        for j in range(n):
            for k in range(w // 2, h - w // 2 + 1):
                difference = sum(abs(physical[i, t, j] - simulated[i, t, j]) for t in range(k - w // 2, k + w // 2 + 1))
                total += difference / w
    return total / (c * n * (h - w))


@pytest.mark.parametrize(("h", "w"), [(20, 10), (12, 4), (9, 2)])
def test_rolling_mean_is_equation_2(h: int, w: int) -> None:
    random = np.random.default_rng(0)
    physical, simulated = random.uniform(-1, 1, (3, h + 4, 8)), random.uniform(-1, 1, (5, 3, h + 4, 8))
    expected = [equation_2(physical, one, h, w) for one in simulated]
    assert rolling_mean(physical, simulated, header=h, window=w) == pytest.approx(expected, rel=1e-12)


def test_samples_after_the_header_do_not_matter() -> None:
    random = np.random.default_rng(1)
    a, b = random.uniform(-1, 1, (2, 40, 8)), random.uniform(-1, 1, (2, 40, 8))
    changed = np.concatenate([b[:, :21], -b[:, 21:]], axis=1)
    assert rolling_mean(a, b) == rolling_mean(a, changed)
    assert rolling_mean(a, a) == 0.0


def test_a_simulation_that_blew_up_is_not_finite() -> None:
    a = np.zeros((1, 21, 8))
    assert not np.isfinite(rolling_mean(a, np.full_like(a, np.nan)))


def test_distance_error_is_equation_1() -> None:
    assert distance_error(np.array([1.0, 2.0]), np.array([[1.5, 1.0], [1.0, 2.0]])) == pytest.approx([0.75, 0.0])
