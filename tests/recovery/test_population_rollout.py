"""A population in one batch: each robot walks as it would alone."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import Change, parse_change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.population_rollout import population_rollout
from estexp_jax.recovery.simulator import DamageSimulator

STEPS = 30


def controllers(n: int, world: DamageSimulator) -> np.ndarray:
    return np.random.default_rng(0).integers(-100, 101, (n, world.n_weights)) / 100


def test_rollout_refuses_shapes_that_do_not_fit(quadruped: Robot) -> None:
    with pytest.raises(InputError, match="one row of 68 weights for each of the 2 robots"):
        population_rollout(quadruped, [[], ["motor_weakness@knee_f loss=0.5"]], np.zeros((1, 68)), steps=30)


def test_rollout_is_each_robots_own_trial(quadruped: Robot, world: DamageSimulator) -> None:
    weights, edits = (
        controllers(3, world),
        [[], ["motor_weakness@knee_f loss=0.5"], [Change("gravity_tilt", None, {"angle": 0.3})]],
    )
    walks = population_rollout(quadruped, edits, weights, steps=STEPS, settle_steps=10)
    assert walks.readings.shape == (3, STEPS, 8) and walks.position.shape == (3, STEPS, 3)
    weak = parse_change("motor_weakness@knee_f loss=0.5", quadruped)
    for i, changes in enumerate([(), (weak,), (edits[2][0],)]):
        assert np.array_equal(walks.readings[i], world.trial(changes, weights[i], STEPS).readings)
    assert not walks.failed.any()
