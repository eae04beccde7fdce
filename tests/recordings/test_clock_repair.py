"""Logs whose clock stands still or runs backwards: rows are dropped and reported."""

from pathlib import Path

import pytest

from tests.recordings.checks.bad_logs import (
    assert_found,
    assert_found_in_real,
    with_repeated_time,
    with_reversed_time,
)

BAD = {
    "time stands still": (with_repeated_time, "time: ", "stands still at 1 rows (first: bad.csv, row 103"),
    "time runs backwards": (with_reversed_time, "time: ", "runs backwards at 1 rows (first: bad.csv, row 302"),
}


@pytest.mark.parametrize("how", BAD)
def test_clock_faults_are_found(arm, tmp_path, how, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_found(BAD[how], arm, Path())


@pytest.mark.parametrize("how", BAD)
def test_clock_faults_are_found_in_real_recordings(real_data, tmp_path, how, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_found_in_real(BAD[how], real_data, Path(), by_text=True)
