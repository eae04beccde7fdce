"""A robot that the simulator is wrong about."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import Change, parse_change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.control.trial import Controller
from estexp_jax.recovery.reality_gap_target import RealityGapTarget
from estexp_jax.recovery.simulator import DamageSimulator
from estexp_jax.recovery.situations import TABLE, situation

STEPS = 60


@pytest.fixture
def controller(world: DamageSimulator) -> Controller:
    weights = np.random.default_rng(2).integers(-100, 101, world.n_weights) / 100
    return replace(world.controller(weights, STEPS), interface=world.closed_loop.interface)


def test_it_walks_much_like_the_simulator_but_not_quite(
    quadruped: Robot, world: DamageSimulator, controller: Controller
) -> None:
    trial = RealityGapTarget(quadruped, (), 1, 10)(controller)
    twin = world.trial((), controller.weights, 30)
    angles = ~world.closed_loop.interface.is_touch
    error = np.abs(trial.readings[:20, angles] - twin.readings[:20, angles])
    assert 1e-4 < error.mean() < 0.08
    assert np.all(np.isfinite(trial.position))


def test_the_same_controller_meets_the_same_robot(quadruped: Robot, controller: Controller) -> None:
    first, second = (RealityGapTarget(quadruped, (), 1, 10)(controller) for _ in range(2))
    assert np.array_equal(first.readings, second.readings)
    assert not np.array_equal(first.readings, RealityGapTarget(quadruped, (), 2, 10)(controller).readings)


@pytest.mark.parametrize("number", TABLE)
def test_every_situation_can_be_planted(quadruped: Robot, controller: Controller, number: int) -> None:
    trial = RealityGapTarget(quadruped, situation(number, quadruped, 3), 1, 5)(replace(controller, steps=5))
    assert np.all(np.isfinite(trial.position))


def test_a_lost_leg_is_silent(quadruped: Robot, world: DamageSimulator, controller: Controller) -> None:
    trial = RealityGapTarget(quadruped, [Change("part_lost", "upper_b", {"lost": 1.0})], 1, 10)(controller)
    names = world.closed_loop.interface.names
    assert np.all(trial.readings[:, names.index("touch_b")] == -1.0)
    assert np.all(trial.readings[:, names.index("angle_b")] == 0.0)


def test_what_mjcf_cannot_say_is_refused(quadruped: Robot) -> None:
    with pytest.raises(InputError, match="foreign robot cannot carry 'back_emf'"):
        RealityGapTarget(quadruped, [parse_change("back_emf@knee_f k=0.1", quadruped)], 1, 10)
