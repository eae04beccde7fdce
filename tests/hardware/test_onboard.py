"""Controllers as plain arrays are those of the simulator."""

import io

import numpy as np
import pytest

from estexp_jax.hardware.onboard import ARRAYS, OnboardController
from estexp_jax.physics.model.robot import Robot
from tests.recovery.loops import controller_of


def test_it_responds_as_the_controller_does(quadruped: Robot) -> None:
    controller = controller_of(quadruped)
    stream = io.BytesIO()
    np.savez(stream, allow_pickle=False, **OnboardController.of(controller, quadruped.names("actuator")).to_arrays())
    stream.seek(0)
    with np.load(stream, allow_pickle=False) as archive:
        assert sorted(archive.files) == sorted(ARRAYS)
        onboard = OnboardController.from_arrays(archive)
    assert onboard.inputs == controller.interface.names and onboard.actuators == quadruped.names("actuator")
    assert (onboard.gain, onboard.control_step, onboard.steps) == (3.0, controller.control_step, controller.steps)
    readings = np.random.default_rng(1).uniform(-1.2, 1.2, (20, len(onboard.inputs)))
    ours, theirs = onboard.hidden(), controller.rest()
    for row in readings:
        (ours, command), (theirs, expected) = onboard.respond(ours, row), controller.respond(theirs, row)
        np.testing.assert_array_equal(command, expected)


def test_arrays_that_do_not_fit_are_told(quadruped: Robot) -> None:
    arrays = OnboardController.of(controller_of(quadruped), quadruped.names("actuator")).to_arrays()
    with pytest.raises(ValueError, match="centre is"):
        OnboardController.from_arrays(arrays | {"centre": np.zeros(3)})
