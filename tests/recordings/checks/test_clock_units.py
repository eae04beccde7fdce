"""The unit of a clock, by its size and by its steps."""

import numpy as np
import pytest

from estexp_jax.recordings.checks.clock_units import likely_clock_unit


@pytest.mark.parametrize(
    ("first", "period", "unit"),
    [
        (0.0, 0.005, ""),
        (0.0, 5.0, "ms"),
        (0.0, 20.0, "ms"),
        (0.0, 5_000.0, "us"),
        (0.0, 5e6, "ns"),
        (1.7e9, 0.005, ""),
        (1.7e12, 5.0, "ms"),
        (1.7e15, 5e3, "us"),
        (1.7e18, 5e6, "ns"),
        (1.7e18, 5e8, "ns"),
    ],
)
def test_units(first, period, unit):
    assert likely_clock_unit(first + period * np.arange(100)) == unit


def test_what_has_no_steps_tells_nothing():
    for times in (np.zeros(5), np.full(3, np.nan), np.empty(0)):
        assert likely_clock_unit(times) == ""
