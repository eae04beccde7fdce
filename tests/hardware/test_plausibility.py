"""Angles in degrees are refused; a wrong sign and exchanged columns are told."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.hardware.plausibility import plausibility_notes
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.control.trial import Controller, Trial
from tests.recovery.loops import controller_of, walked

FIRST, COMPARED = 4, 41
"""Index of the first angle: the quadruped's touch sensors come before."""


@pytest.fixture(scope="module")
def controller(quadruped: Robot) -> Controller:
    return controller_of(quadruped)


@pytest.fixture
def trial(controller: Controller) -> Trial:
    return walked(controller)


def notes(controller: Controller, trial: Trial) -> tuple[str, ...]:
    return plausibility_notes(controller, trial, walked(controller), COMPARED, "trial_0.csv")


def test_a_sound_trial_passes_and_so_does_one_of_a_damaged_robot(controller: Controller, trial: Trial) -> None:
    assert notes(controller, trial) == ()
    trial.readings[:, FIRST] = 0.1  # a joint that does not move
    trial.readings[:, FIRST + 1] *= 0.2  # a weak sensor
    assert notes(controller, trial) == ()


def test_degrees_are_refused(controller: Controller, trial: Trial) -> None:
    trial.readings[:, FIRST:] = np.rad2deg(trial.readings[:, FIRST:])
    with pytest.raises(InputError, match=r"trial_0\.csv, column 'sensor\.angle_.': .* turns .*; log angles in radians"):
        notes(controller, trial)


def test_a_joint_that_is_to_turn_may(controller: Controller, trial: Trial) -> None:
    predicted = walked(controller)
    for one in (trial, predicted):
        one.readings[:, FIRST] = np.linspace(0.0, 30.0, len(one.time))  # a wheel
    assert plausibility_notes(controller, trial, predicted, COMPARED, "trial_0.csv") == ()


def test_a_wrong_sign_is_told_by_its_column(controller: Controller, trial: Trial) -> None:
    trial.readings[:, FIRST + 2] *= -1.0
    [said] = notes(controller, trial)
    assert controller.interface.names[FIRST + 2] in said and "sign" in said


def test_exchanged_columns_are_told(controller: Controller, trial: Trial) -> None:
    trial.readings[:, [FIRST, FIRST + 1]] = trial.readings[:, [FIRST + 1, FIRST]]
    [said] = notes(controller, trial)
    assert all(controller.interface.names[k] in said for k in (FIRST, FIRST + 1)) and "exchanged" in said
