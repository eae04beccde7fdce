"""Texts of times: time stamps, and durations as pandas, DuckDB, polars, Python and MATLAB write them."""

import numpy as np
import pytest

from estexp_jax.recordings.readers.stamps import parsed_stamps, seconds


@pytest.mark.parametrize(
    ("texts", "expected"),
    [
        (["0 days 00:00:01.500000", "", "1 days 00:00:00"], [1.5, np.nan, 86_400.0]),
        (["-1 days +23:59:59.5", "0 days 00:00:00"], [-0.5, 0.0]),
        (["1 day 00:00:00", "3 days 01:00:00.25"], [86_400.0, 262_800.25]),
        (["1 day, 0:00:01", "0:00:02"], [86_401.0, 2.0]),
        (["PT0S", "PT1M0.125S", "P1DT2H", "P0DT0H0M1S"], [0.0, 60.125, 93_600.0, 1.0]),
        (["10:20:30.5", "00:01"], [37_230.5, 1.0]),
        (["0.5 sec", "2 min", "20 ms"], [0.5, 120.0, 0.02]),
    ],
)
def test_durations(texts, expected):
    found = parsed_stamps(texts)
    assert found is not None
    np.testing.assert_allclose(seconds(found), expected, atol=1e-9)


@pytest.mark.parametrize(
    "text", ["P1D", "1 day", "999999 days 00:00:00", "PT1,5S", "-00:01", "1 days 2026-01-01", "PT"]
)
def test_what_is_no_duration(text):
    assert parsed_stamps([text, text]) is None
