"""A clock that runs fast stretches a log; two clocks drift apart."""

import numpy as np
import pytest

from estexp_jax.physics.effects.catalogue.clock_scale import ClockScale
from tests.estimation.two_links import arm, faulty, log_of


def test_a_fast_clock_makes_a_log_longer():
    right = log_of(arm())
    assert faulty(arm(), right, "clock_scale factor=1.1").duration == pytest.approx(1.1 * right.duration)


def test_readings_with_a_clock_of_their_own_move_against_commands():
    right = log_of(arm())
    wrong = faulty(arm(), right, "clock_scale@* factor=1.01")
    late = wrong.time[np.isfinite(wrong.sensor[:, 0])]
    np.testing.assert_allclose(late, 1.01 * right.time, atol=1e-9)
    at = np.arange(1.0, 7.0, 0.1)
    rows = [np.searchsorted(log.time, at, side="right") - 1 for log in (right, wrong)]
    assert np.abs(right.ctrl[rows[0]] - wrong.ctrl[rows[1]]).max() < 0.03


def test_clocks_that_are_tried_are_no_further_apart_than_told():
    e, recording = ClockScale(), log_of(arm())
    (low, high) = e.bounds(arm(), "*")[0]
    assert all(low <= factor <= high for (factor,) in e.tried(arm(), "*", recording))
    assert e.looks_like_physics("") and not e.looks_like_physics("*")
