"""The next trial: the one that tells explanations apart."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.exploration.disagreement import most_informative, remaining_probability
from estexp_jax.recovery.simulator import DamageSimulator

WEAK = (Change("motor_weakness", "knee_f", {"loss": 0.6}),)
LOST = (Change("part_lost", "upper_b", {"lost": 1.0}),)


@pytest.fixture(scope="module")
def controllers(world: DamageSimulator) -> np.ndarray:
    """One that holds still, and three that do not."""
    random = np.random.default_rng(8).integers(-100, 101, (3, world.n_weights)) / 100
    return np.concatenate([np.zeros((1, world.n_weights)), random])


def test_what_foretells_the_same_is_never_told_apart(
    world: DamageSimulator, settings: Settings, controllers: np.ndarray
) -> None:
    rough = replace(settings, robot="foreign")
    left = remaining_probability(world, rough, controllers, [(LOST, 0.5), (LOST, 0.3)])
    np.testing.assert_allclose(left, 1.0, atol=1e-9)


@pytest.mark.parametrize("robot", ["same", "foreign"])
def test_a_weak_motor_shows_only_where_it_moves(
    world: DamageSimulator, settings: Settings, controllers: np.ndarray, robot: str
) -> None:
    chosen = replace(settings, robot=robot)  # pyright: ignore[reportArgumentType]
    still, *moving = remaining_probability(world, chosen, controllers, [(WEAK, 0.6), ((), 0.4)])
    assert still > 10.0 * max(moving)


def test_rivals_count_by_their_probability(world: DamageSimulator, settings: Settings, controllers: np.ndarray) -> None:
    rough = replace(settings, robot="foreign")
    weak, lost = (remaining_probability(world, rough, controllers, [((), 0.5), (rival, 0.2)]) for rival in (WEAK, LOST))
    both = remaining_probability(world, rough, controllers, [((), 0.5), (WEAK, 0.3), (LOST, 0.1)])
    np.testing.assert_allclose(both, 0.75 * weak + 0.25 * lost, rtol=1e-6, atol=1e-12)


def test_of_those_that_tell_about_as_much_the_first_counts() -> None:
    assert most_informative(np.array([0.5, 0.011, 0.3, 0.0])) == 1
    assert most_informative(np.array([0.5, 0.05, 0.3, 0.0])) == 3
