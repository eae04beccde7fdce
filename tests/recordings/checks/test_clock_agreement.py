"""Readings stamped before their commands, and by a clock that runs fast, are told; slow servos are not."""

import numpy as np
import pytest

from estexp_jax.recordings.checks.clock_agreement import agreement_faults, lag_drift, moves_before_commands


def _servo(duration, lag_s=0.05, seed=0):
    """Time, a command with rests, and a joint that follows it as a lag of first order, with an encoder."""
    random = np.random.default_rng(seed)
    time = np.arange(0.0, duration, 0.005)
    moving = np.sin(1.7 * time) + 0.5 * np.sin(4.1 * time + 1.0)
    command = np.where((time % 3.0) < 2.2, moving, np.nan)
    last = np.maximum.accumulate(np.where(np.isnan(command), 0, np.arange(len(time))))
    command = command[last] + 0.0 * random.random()
    reading = np.zeros(len(time))
    for k in range(1, len(time)):
        reading[k] = reading[k - 1] + 0.005 / lag_s * (command[k - 1] - reading[k - 1])
    return time, command, np.round(reading / 0.0004) * 0.0004


@pytest.mark.parametrize("shift", [-0.04, -0.02, 0.0, 0.04])
def test_readings_that_move_before_their_command(shift):
    time, command, reading = _servo(12.0)
    early = moves_before_commands(time, command, np.interp(time, time + shift, reading))
    assert early == (pytest.approx(-shift, abs=0.012) if shift < 0 else 0.0)


@pytest.mark.parametrize(("rate", "duration"), [(1.005, 60.0), (0.995, 60.0), (1.02, 30.0), (1.0, 60.0), (1.0, 20.0)])
def test_a_clock_that_runs_fast(rate, duration):
    time, command, reading = _servo(duration)
    drift, change = lag_drift(time, command, np.interp(time, time * rate, reading))
    if rate == 1.0:
        assert (drift, change) == (0.0, 0.0)
    else:
        assert drift == pytest.approx(rate - 1.0, rel=0.2) and change == pytest.approx(abs(drift) * duration, rel=0.02)


def test_both_are_told_with_their_remedy():
    time, command, reading = _servo(60.0)
    [fault] = agreement_faults("sensor.a", time, command, np.interp(time, time * 1.005, reading))
    assert fault.kind == "clock_drift" and "reading's clock runs fast" in fault.sentence
    [fault] = agreement_faults("sensor.a", time, command, np.interp(time, time - 0.04, reading))
    assert fault.kind == "ahead" and "stamp both by one clock" in fault.sentence
    assert not list(agreement_faults("sensor.a", time, command, reading))


def test_a_joint_that_creeps_does_not_begin_to_move_before_its_command():
    time = np.arange(300) / 100
    command = np.where(time < 1.0, 0.0, 0.5)
    creeping = np.where(time < 1.02, 0.02 * time, 0.02 * time + 0.5 * (1.0 - np.exp(-10.0 * (time - 1.02))))
    assert moves_before_commands(time, command, creeping) == 0.0
    early = np.where(time < 0.94, 0.0, 0.5 * (1.0 - np.exp(-10.0 * (time - 0.94))))
    assert moves_before_commands(time, command, early) > 0.03
