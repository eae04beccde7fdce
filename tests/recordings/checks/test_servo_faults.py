"""Faults between a command and its joint: each is found in a corrupted log."""

from pathlib import Path

import numpy as np
import pytest

from tests.recordings.checks.bad_logs import (
    assert_found,
    assert_found_in_real,
    changed,
    shifted,
    with_stuck_sensor,
)

BAD = {
    "command in degrees": (
        lambda log: changed(log, "ctrl.servo", np.degrees),
        "degrees",
        "is it in degrees",
    ),
    "wrong sign": (lambda log: changed(log, "sensor.angle", np.negative), "sign", "scale = -1.0"),
    "a stuck sensor": (with_stuck_sensor, "stuck", "stands still from"),
    "a saturated command": (
        lambda log: changed(log, "ctrl.servo", lambda v: np.clip(2.5 * v, -1.5, 1.5)),
        "saturation",
        "at or beyond its limits",
    ),
    "readings from the future": (lambda log: shifted(log, "sensor.angle", 0.2), "ahead", "before its command"),
    "late readings": (lambda log: shifted(log, "sensor.angle", -0.25), "late", "follows its command 0.2"),
}


@pytest.mark.parametrize("how", BAD)
def test_servo_faults_are_found(arm, tmp_path, how, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_found(BAD[how], arm, Path())


@pytest.mark.parametrize("how", [how for how in BAD if how != "a saturated command"])
def test_servo_faults_are_found_in_real_recordings(real_data, tmp_path, how, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert_found_in_real(BAD[how], real_data, Path())
