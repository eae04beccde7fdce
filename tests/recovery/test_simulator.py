"""A robot's walk is its own business."""

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import Change, parse_change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.damage_sites import DamageSite, change_of
from estexp_jax.recovery.simulator import DamageSimulator, damage_simulator

STEPS = 30


def controllers(n: int, world: DamageSimulator) -> np.ndarray:
    return np.random.default_rng(0).integers(-100, 101, (n, world.n_weights)) / 100


def test_a_walk_does_not_depend_on_its_place_in_the_batch(world: DamageSimulator) -> None:
    weights, start = controllers(40, world), world.settled([()])
    walks, order = world.rollouts([()], start, weights, STEPS), np.random.default_rng(1).permutation(40)
    assert np.array_equal(walks.position[:, order], world.rollouts([()], start, weights[order], STEPS).position)
    assert np.array_equal(walks.readings[0, 33], world.trial((), weights[33], STEPS).readings)


def test_trials_of_many_robots_are_those_of_each(world: DamageSimulator, quadruped: Robot) -> None:
    sets = [
        (),
        (change_of(quadruped, DamageSite("part_lost", "upper_l"), 1.0),),
        (Change("gravity_tilt", None, {"angle": 0.3}),),
    ]
    weights = controllers(2, world)
    many = world.trials(sets, weights, STEPS)
    assert many.readings.shape == (3, 2, STEPS, 8)
    for i, changes in enumerate(sets):
        for j in range(2):
            assert np.array_equal(many.readings[i, j], world.trial(changes, weights[j], STEPS).readings)


def test_a_lost_leg_shows_its_sensors_at_rest(world: DamageSimulator, quadruped: Robot) -> None:
    lost = change_of(quadruped, DamageSite("part_lost", "upper_l"), 1.0)
    trial = world.trial([lost], controllers(1, world)[0], STEPS)
    names = world.closed_loop.interface.names
    assert np.all(trial.readings[:, names.index("touch_l")] == -1.0)
    assert np.all(trial.readings[:, names.index("angle_l")] == 0.0)
    assert np.ptp(trial.readings[:, names.index("angle_r")]) > 0.01


def test_effects_without_a_place_in_closed_loop_are_refused(quadruped: Robot) -> None:
    late = parse_change("command_delay@knee_f delay=0.02", quadruped)
    with pytest.raises(InputError, match="closed loop"):
        damage_simulator(quadruped, Settings(), [late])
