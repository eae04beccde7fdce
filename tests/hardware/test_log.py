"""Recordings of trials by robots' own clocks, brought to control steps."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.hardware.log import ExpectedTrial, trial_of_recording
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.control.trial import Controller, Trial
from tests.recovery.loops import PERIOD, STEPS, controller_of, readings_at, recorded, walked

COMPARED = 41


@pytest.fixture(scope="module")
def controller(quadruped: Robot) -> Controller:
    return controller_of(quadruped)


@pytest.fixture(scope="module")
def trial(controller: Controller) -> Trial:
    return walked(controller)


@pytest.fixture(scope="module")
def wanted(controller: Controller) -> ExpectedTrial:
    return ExpectedTrial(controller, walked(controller, phase=1.3), "x", COMPARED)


def test_rows_at_the_control_steps_are_the_trial(quadruped: Robot, trial: Trial, wanted: ExpectedTrial) -> None:
    found, notes = trial_of_recording(quadruped, recorded(quadruped, wanted.controller, trial), wanted, "trial_0.csv")
    assert notes == () and found.open_loop_readings is None
    for name in ("time", "readings", "commands", "position"):
        np.testing.assert_allclose(getattr(found, name), getattr(trial, name), atol=1e-12)


@pytest.mark.parametrize(
    ("rate", "jitter", "drift"),
    [(200.0, 0.0, 1.0), (1000.0, 0.0, 1.0), (100.0, 0.003, 1.0), (100.0, 0.0, 1.005), (100.0, 0.0, 0.995)],
    ids=["200 Hz", "1 kHz", "jitter", "slow clock", "fast clock"],
)
def test_other_clocks_give_the_same_trial(
    rate: float, jitter: float, drift: float, quadruped: Robot, trial: Trial, wanted: ExpectedTrial
) -> None:
    random = np.random.default_rng(1)
    time = drift * np.arange(0.0, STEPS * PERIOD - 1e-9, 1.0 / rate)
    time[1:] += random.uniform(-jitter, jitter, len(time) - 1)
    found, _ = trial_of_recording(quadruped, recorded(quadruped, wanted.controller, trial, time), wanted, "trial_0.csv")
    touch, inside = wanted.controller.interface.is_touch, slice(0, STEPS - 1)
    np.testing.assert_allclose(found.readings[inside, ~touch], trial.readings[inside, ~touch], atol=2e-3)
    assert np.mean(found.readings[:, touch] != trial.readings[:, touch]) < 0.02
    np.testing.assert_allclose(found.commands, trial.commands, atol=1e-12)
    assert found.distance("x") == pytest.approx(trial.distance("x"), abs=0.02)
    assert found.open_loop_readings is None


def test_commands_that_were_played_are_heard_as_foretold(quadruped: Robot, trial: Trial, wanted: ExpectedTrial) -> None:
    played = replace(recorded(quadruped, wanted.controller, trial), ctrl=wanted.predicted.commands)
    found, _ = trial_of_recording(quadruped, played, wanted, "trial_0.csv")
    assert found.open_loop_readings is wanted.predicted.readings
    np.testing.assert_allclose(found.readings, trial.readings, atol=1e-12)
    kept = Trial.from_tree(found.to_tree())
    np.testing.assert_array_equal(kept.network_readings, wanted.predicted.readings)


def test_commands_of_nobody_are_refused(quadruped: Robot, trial: Trial, wanted: ExpectedTrial) -> None:
    log = recorded(quadruped, wanted.controller, trial)
    log.ctrl[:, 3] *= -1.0
    with pytest.raises(InputError, match=r"column 'ctrl\.knee_l': commands are off by .* signs"):
        trial_of_recording(quadruped, log, wanted, "trial_0.csv")


def test_a_short_one_is_refused(quadruped: Robot, trial: Trial, wanted: ExpectedTrial) -> None:
    log = recorded(quadruped, wanted.controller, trial, trial.time[:40])
    with pytest.raises(InputError, match=r"column 'time': lasts 0\.39 s, a trial 0\.6 s"):
        trial_of_recording(quadruped, log, wanted, "trial_0.csv")


def test_gaps_are_filled_where_nothing_is_compared(quadruped: Robot, trial: Trial, wanted: ExpectedTrial) -> None:
    knee = wanted.controller.interface.names.index("angle_f")
    column = wanted.controller.interface.columns[knee]
    log = recorded(quadruped, wanted.controller, trial)
    log.sensor[[3, 4, 5], column] = np.nan
    found, notes = trial_of_recording(quadruped, log, wanted, "trial_0.csv")
    assert notes == () and np.allclose(found.readings[:, knee], trial.readings[:, knee], atol=1e-2)
    log.sensor[45:55, column] = np.nan
    assert "angle_f: no sample for 0.11 s" in trial_of_recording(quadruped, log, wanted, "trial_0.csv").notes[0]
    log.sensor[10:20, column] = np.nan
    with pytest.raises(InputError, match=r"'sensor\.angle_f': no sample for 0\.11 s, 0\.09 s after the first row"):
        trial_of_recording(quadruped, log, wanted, "trial_0.csv")
    log.sensor[:, column] = np.nan
    with pytest.raises(InputError, match="has no sample; the controller reads"):
        trial_of_recording(quadruped, log, wanted, "trial_0.csv")


def test_a_distance_may_be_measured_by_hand_or_not_at_all(
    quadruped: Robot, trial: Trial, wanted: ExpectedTrial
) -> None:
    log = recorded(quadruped, wanted.controller, trial)
    log.qpos[:] = np.nan
    found, notes = trial_of_recording(quadruped, log, wanted, "trial_0.csv")
    assert np.isnan(found.distance("x")) and "distance is not known" in notes[0] and "qpos.root.0" in notes[0]
    with pytest.raises(InputError, match=r"--metric distance compares it; .*qpos\.\w+\.0"):
        trial_of_recording(quadruped, log, replace(wanted, needs_distance=True), "trial_0.csv")
    log.qpos[[0, -1], 0] = 0.0, 0.43
    found, _ = trial_of_recording(quadruped, log, replace(wanted, needs_distance=True), "trial_0.csv")
    assert found.distance("x") == 0.43
    log.qpos[30:, 0] = np.nan  # lost on the way
    assert np.isnan(trial_of_recording(quadruped, log, wanted, "trial_0.csv").trial.distance("x"))


def test_rows_further_apart_than_control_steps_are_told(quadruped: Robot, trial: Trial, wanted: ExpectedTrial) -> None:
    time = np.arange(0.0, STEPS * PERIOD, 0.02)
    steady = replace(wanted, predicted=trial)
    assert (
        "0.02 s apart"
        in trial_of_recording(quadruped, recorded(quadruped, wanted.controller, trial, time), steady, "").notes[0]
    )


def test_made_up_readings_are_those_of_any_clock(controller: Controller, trial: Trial) -> None:
    np.testing.assert_array_equal(readings_at(controller, trial.time), trial.readings)
