"""What tests of several estimation methods need."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.simulator import DamageSimulator
from tests.recovery.estimation.lost_leg import PLANTED, OpenLoopTrials


@pytest.fixture(scope="session")
def rough(settings: Settings) -> Settings:
    """Of a robot that the simulator describes with errors only."""
    return replace(settings, robot="foreign")


@pytest.fixture(scope="session")
def open_loop(world: DamageSimulator, rough: Settings) -> OpenLoopTrials:
    weights = np.random.default_rng(5).integers(-100, 101, world.n_weights) / 100
    predicted = world.trial((), weights, rough.steps)
    rollout = world.trials([PLANTED], weights[None], rough.steps, predicted.readings[None])
    np.testing.assert_array_equal(rollout.commands[0, 0], predicted.commands)
    wrong = Trial(predicted.time, rollout.readings[0, 0], predicted.commands, rollout.position[0, 0])
    return OpenLoopTrials(weights, replace(wrong, open_loop_readings=predicted.readings), wrong)
