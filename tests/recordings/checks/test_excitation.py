"""Which groups of effects a motion can distinguish, and what to record otherwise."""

import numpy as np
import pytest

from estexp_jax.recordings.checks.excitation import SUSPECTS, missing
from tests.recordings.checks.bad_logs import check, servo_log


def test_a_rich_motion_distinguishes_all(arm, tmp_path):
    result = check(servo_log(), tmp_path, arm)
    assert result["joints"]["elbow"]["tells"] == dict.fromkeys(SUSPECTS, True)
    assert list(missing([result, result])) == []


@pytest.mark.parametrize(
    ("motion", "lack"),
    [
        (lambda t: 1.2 * np.abs((t / 4) % 2 - 1), "slowly and fast"),
        (lambda t: 0.1 * t, "hardly turns round"),
        (lambda t: 0.1 * np.sin(9 * t), "narrow range"),
        (lambda t: 0.8 * np.sin(0.5 * t), "never changes quickly"),
    ],
)
def test_what_a_motion_cannot_distinguish_is_reported(arm, tmp_path, motion, lack):
    time = np.arange(0.0, 16.0, 0.01)
    result = check({"time": time, "ctrl.servo": motion(time), "sensor.angle": motion(time - 0.02)}, tmp_path, arm)
    assert any(lack in sentence for sentence in missing([result, result]))
