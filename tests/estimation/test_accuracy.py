"""Errors, excess and gain as the specification defines them."""

import numpy as np
import pytest

from estexp_jax.estimation.accuracy import excess, gain, nrmse


def test_sensors_and_recordings_weigh_the_same_however_many_samples_they_have():
    a = np.array([[4.0, np.nan], [4.0, 1.0], [4.0, np.nan]])
    b = np.array([[0.0, np.nan]])
    assert nrmse([a, b]) == pytest.approx(np.sqrt((4.0 + 1.0 + 0.0) / 3.0))


def test_no_sample_gives_no_error():
    assert np.isnan(nrmse([np.full((3, 2), np.nan)]))


def test_excess_is_what_noise_does_not_give():
    assert excess(5.0, 3.0) == pytest.approx(4.0)
    assert excess(2.0, 3.0) == 0.0


def test_gain_is_the_share_of_the_excess_removed():
    assert gain(np.hypot(1.0, 3.0), 5.0, 3.0) == pytest.approx(0.75)
    assert gain(3.0, 5.0, 3.0) == 1.0
    assert gain(np.hypot(8.0, 3.0), 5.0, 3.0) == pytest.approx(-1.0)
    assert np.isnan(gain(1.0, 2.0, 3.0))
