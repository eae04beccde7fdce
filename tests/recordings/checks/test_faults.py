"""Faults of the clock and of single readings: each is found in a corrupted log."""

from pathlib import Path

import numpy as np
import pytest

from estexp_jax.cli.main import main
from estexp_jax.recordings.write import write_csv
from tests.recordings.checks.bad_logs import (
    ARM,
    STEP,
    assert_found,
    assert_found_in_real,
    changed,
    clip,
    hold_samples,
    servo_log,
    with_dropouts,
    with_jitter,
    with_pause,
    with_reversed_time,
    with_spikes,
)

BAD = {
    "a gap of the clock": (with_pause, "clock_gap", "the longest 0.7"),
    "an uneven clock": (with_jitter, "clock_jitter", "the clock is uneven"),
    "time in ms": (lambda log: changed(log, "time", lambda t: 1e3 * t), "time_unit", "another unit"),
    "angle in degrees": (lambda log: changed(log, "sensor.angle", np.degrees), "degrees", 'unit = "deg"'),
    "raw ticks": (
        lambda log: changed(log, "sensor.angle", lambda v: np.round(v / STEP) + 2048.0),
        "ticks",
        "raw encoder ticks",
    ),
    "a sensor read too seldom": (
        lambda log: changed(log, "sensor.angle", hold_samples(4)),
        "stale",
        "repeats the reading",
    ),
    "a coarse encoder": (
        lambda log: changed(log, "sensor.angle", lambda v: np.round(v / 0.1) * 0.1),
        "coarse_encoder",
        "steps of its encoder",
    ),
    "a cut-off reading": (lambda log: changed(log, "sensor.angle", clip), "clipped", "is cut off at"),
    "spikes": (with_spikes, "spikes", "5 single readings jump"),
    "dropouts": (with_dropouts, "dropouts", "gaps without a sample"),
    "speed in degrees": (
        lambda log: changed(log, "sensor.rate", np.degrees),
        "speed_unit",
        "times the slope of sensor.angle",
    ),
}


@pytest.mark.parametrize("how", BAD)
def test_faults_are_found(arm, tmp_path, how, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_found(BAD[how], arm, Path())


@pytest.mark.parametrize("how", [how for how in BAD if how != "speed in degrees"])
def test_faults_are_found_in_real_recordings(real_data, tmp_path, how, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_found_in_real(BAD[how], real_data, Path(), by_text="time" in how)


def test_faults_reach_the_terminal(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(ARM)
    write_csv(tmp_path / "bad.csv", with_reversed_time(with_spikes(servo_log())))
    assert main(["check", "arm.xml", "bad.csv"]) == 0
    output = capsys.readouterr().out
    assert "runs backwards" in output and "jump away" in output and "to record: one recording only" in output
