"""Scores of controllers on simulators with errors."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.physics.engines.closed_loop import ReadingOverride
from estexp_jax.recovery.control.trial import distances_along
from estexp_jax.recovery.cycle import Job
from estexp_jax.recovery.exploration.explore import exploration_score, rank_controllers, validation_ensemble
from estexp_jax.recovery.model_error import perturbed_robots, sensor_noise
from estexp_jax.search.genetic import Population


def test_a_rough_simulator_is_several_with_noise_in_exploration(job: Job) -> None:
    rough, lost, world = replace(job.settings, model_error=0.05), job.planted, job.simulator
    weights = np.random.default_rng(3).uniform(-1.0, 1.0, (2, world.n_weights))
    robots = perturbed_robots(world.robot, 0.05, rough.ensemble_size)
    noise = sensor_noise(world.closed_loop.interface, rough.ensemble_size, rough.steps)
    walks = []
    for i, robot in enumerate(robots):
        one = ReadingOverride(noise.factor[i, None, None], noise.added[i, None, None])
        walk = world.rollouts([(*lost, *robot)], world.settled([(*lost, *robot)]), weights[1:], rough.steps, one)
        walks.append(distances_along(walk.position, "x")[0, 0])
    assert exploration_score(world, rough, lost)(weights)[1] == pytest.approx(-np.mean(walks), abs=1e-6)
    assert rough.ensemble_size == 4 and len(set(walks)) == 4
    single = [replace(rough, paper=True), job.settings, replace(rough, ensemble=1)]
    assert [settings.ensemble_size for settings in single] == [1, 1, 1]


def test_simulators_that_the_search_did_not_see_choose_among_its_last_and_what_was_tried(job: Job) -> None:
    rough, lost, world = replace(job.settings, model_error=0.05), job.planted, job.simulator
    weights = np.random.default_rng(5).uniform(-1.0, 1.0, (6, world.n_weights))
    first = exploration_score(world, rough, lost)(weights)
    order = np.argsort(first)
    population = Population(weights[order], first[order], 3, 0)
    tried = [np.full(world.n_weights, 0.1), np.full(world.n_weights, 0.2)]
    genomes, scores = rank_controllers(world, rough, lost, population, tried, last=True)
    candidates = [*population.genomes[:2], tried[1]]
    assert (
        validation_ensemble(rough) == 8 and len({w.tobytes() for w in genomes} & {w.tobytes() for w in candidates}) == 3
    )
    again = [exploration_score(world, rough, lost, draw)(np.array(candidates)) for draw in range(1, 9)]
    np.testing.assert_allclose(scores, np.sort(np.mean(again, axis=0)), atol=1e-6)
    assert np.all(np.ptp(again, axis=0)[:2] > 0.0) and not np.any(np.isclose(scores, first[order][0], atol=1e-9))
    before, _ = rank_controllers(world, rough, lost, population, [population.genomes[0], *tried], last=False)
    assert {w.tobytes() for w in before} == {w.tobytes() for w in population.genomes[1:4]}, "new ones only"
    exact, _ = rank_controllers(world, job.settings, lost, population, tried, last=True)
    assert exact is population.genomes and validation_ensemble(job.settings) == 0
