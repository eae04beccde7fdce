"""The whole loop, small: its order, its record, and that it goes on from any state bit for bit."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.physics.engines.closed_loop import ReadingOverride
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings, quick_settings
from estexp_jax.recovery.control.trial import Controller, Trial, distances_along
from estexp_jax.recovery.cycle import Job, job_of, run_cycle
from estexp_jax.recovery.exploration.explore import exploration_score, rank_controllers, validation_ensemble
from estexp_jax.recovery.model_error import perturbed_robots, sensor_noise
from estexp_jax.recovery.state import RunState
from estexp_jax.search.genetic import Population


def equal(a: Any, b: Any) -> bool:
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(equal(a[k], b[k]) for k in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(equal(x, y) for x, y in zip(a, b, strict=True))
    return bool(np.array_equal(a, b, equal_nan=isinstance(a, float)))


@pytest.fixture(scope="module", params=[False, True], ids=["set search", "paper"])
def variant(request: pytest.FixtureRequest, job: Job) -> Job:
    return replace(job, settings=replace(job.settings, paper=request.param))


@pytest.fixture(scope="module")
def states(variant: Job) -> list[RunState]:
    return list(run_cycle(variant))


def test_phases_follow_the_paper(variant: Job, states: list[RunState]) -> None:
    last, settings = states[-1], variant.settings
    assert last.phase == "done"
    assert len(last.controllers) == settings.passes + 1 == len(last.trials) == len(last.simulated)
    assert len(last.diagnoses) == settings.passes == len(last.passes("x"))
    phases = list(dict.fromkeys((row.number, row.phase) for row in last.history))
    assert phases == [(0, "exploration")] + [(i, p) for i in (1, 2) for p in ("estimation", "exploration")]


def test_every_generation_is_in_the_history(variant: Job, states: list[RunState]) -> None:
    for number in range(variant.settings.passes + 1):
        rows = [row for row in states[-1].history if (row.number, row.phase) == (number, "exploration")]
        assert [row.generation for row in rows] == list(range(1, variant.settings.generations + 1))
        assert np.all(np.diff([row.best for row in rows]) >= 0.0)
        assert rows[-1].best == states[-1].simulated[number]


@pytest.mark.parametrize("share", [0.0, 0.2, 0.5, 0.7, 0.9])
def test_going_on_from_any_state_gives_the_same_bits(variant: Job, states: list[RunState], share: float) -> None:
    kept = RunState.from_tree(states[int(share * len(states))].to_tree())
    assert equal(list(run_cycle(variant, kept))[-1].to_tree(), states[-1].to_tree())


def test_controllers_start_from_the_robot_as_diagnosed(variant: Job, states: list[RunState]) -> None:
    last = states[-1]
    for i, diagnosis in enumerate([(), *last.diagnoses]):
        score = exploration_score(variant.simulator, variant.settings, diagnosis)
        assert score(last.controllers[i][None])[0] == -last.simulated[i]


def test_a_rough_simulator_is_several_with_noise_in_exploration(job: Job) -> None:
    rough, lost, world = replace(job.settings, model_error=0.05), job.planted, job.simulator
    weights = np.random.default_rng(3).uniform(-1.0, 1.0, (2, world.n_weights))
    robots, told = (
        perturbed_robots(world.robot, 0.05, rough.ensemble_size),
        sensor_noise(world.closed_loop.interface, rough.ensemble_size, rough.steps),
    )
    walks = []
    for i, robot in enumerate(robots):
        one = ReadingOverride(told.factor[i, None, None], told.added[i, None, None])
        walk = world.walks([(*lost, *robot)], world.settled([(*lost, *robot)]), weights[1:], rough.steps, one)
        walks.append(distances_along(walk.position, "x")[0, 0])
    assert exploration_score(world, rough, lost)(weights)[1] == pytest.approx(-np.mean(walks), abs=1e-6)
    assert rough.ensemble_size == 4 and len(set(walks)) == 4
    assert (
        replace(rough, paper=True).ensemble_size
        == 1
        == job.settings.ensemble_size
        == replace(rough, ensemble=1).ensemble_size
    )


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


def test_noise_is_in_angles_and_turns_touch_round(job: Job) -> None:
    face = job.simulator.closed_loop.interface
    told = sensor_noise(face, 3, 400)
    assert np.std(told.added[..., ~face.is_touch]) == pytest.approx(0.005, rel=0.05)
    assert not np.any(told.added[..., face.is_touch]) and np.all(told.factor[..., ~face.is_touch] == 1.0)
    assert np.mean(told.factor[..., face.is_touch] == -1.0) == pytest.approx(0.02, abs=0.006)


def test_an_exact_diagnosis_foretells_the_trial(job: Job) -> None:
    last = list(run_cycle(job))[-1]
    assert last.diagnoses[-1] == job.planted
    assert last.passes("x")[-1].hardware == last.simulated[-1]


def test_any_callable_is_a_target(job: Job) -> None:
    calls: list[int] = []

    def still(controller: Controller) -> Trial:
        hidden, commands = controller.respond(controller.rest(), job.simulator.closed_loop.interface.rest)
        assert hidden.shape == (3,) and commands.shape == (8,)
        calls.append(controller.steps)
        rows = controller.steps
        return Trial(np.arange(rows) * 0.01, np.zeros((rows, 8)), np.zeros((rows, 8)), np.zeros((rows, 3)))

    settings = replace(job.settings, paper=True)
    last = list(run_cycle(replace(job, settings=settings, target=still, healthy=None, planted=())))[-1]
    assert calls == [30, 30, 30]
    assert [trial.distance("x") for trial in last.trials] == [0.0] * 3
    assert last.before is not None and last.before.distance("x") == last.simulated[0]


def test_impossible_settings_are_the_users_errors() -> None:
    wrongs: list[dict[str, Any]] = [
        {"situation": 14},
        {"population": 2},
        {"window": 5},
        {"steps": 20},
        {"settle_steps": 2000},
        {"ensemble": 0},
        {"ensemble": 4},
    ]
    for wrong in wrongs:
        with pytest.raises(InputError, match=f"--{next(iter(wrong)).replace('_', '-')}"):
            Settings(**wrong)
    assert quick_settings(Settings(seed=5)).seed == 5


@pytest.mark.slow
def test_the_whole_loop_on_a_robot_that_is_not_its_simulator(job: Job, quadruped: Robot) -> None:
    settings = replace(job.settings, robot="foreign", passes=1)
    foreign = job_of(quadruped, settings, world=job.simulator)
    states = list(run_cycle(foreign))
    last = states[-1]
    assert last.phase == "done" and last.alarms == (False,)
    assert sum(p for _, p in last.alternatives[0]) + (last.probabilities[0] or 0.0) <= 1.0 + 1e-9
    estimating = [state for state in states if state.phase == "estimation" and state.search is not None]
    kept = RunState.from_tree(estimating[len(estimating) // 2].to_tree())
    assert equal(list(run_cycle(foreign, kept))[-1].to_tree(), last.to_tree())
