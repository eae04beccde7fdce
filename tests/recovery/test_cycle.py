"""The whole loop, small: its order, its record, and that it goes on from any state bit for bit."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.cycle import Job, job_of, run_cycle
from estexp_jax.recovery.estimation.damage_sites import DamageSite
from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.recovery.estimation.method import DamageDiagnosis
from estexp_jax.recovery.estimation.set_estimation import SetEstimation
from estexp_jax.recovery.exploration.explore import exploration_score
from estexp_jax.recovery.state import RunState


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


def test_an_exact_diagnosis_foretells_the_trial(job: Job) -> None:
    last = list(run_cycle(job))[-1]
    assert last.diagnoses[-1] == job.planted
    assert last.passes("x")[-1].hardware == last.simulated[-1]


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


def test_the_robot_tries_what_tells_most_and_at_last_what_comes_farthest(
    job: Job, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A diagnosis that leaves rivals: among controllers nearly as good as the best, another one is tried."""
    weak: DamageHypothesis = ((DamageSite("motor_weakness", "knee_f"), 0.6),)
    doubtful = DamageDiagnosis((), 0.0, 0.5, ((weak, 0.5),), alarm=False)
    monkeypatch.setattr(SetEstimation, "diagnosis", lambda *_: doubtful)
    asked: list[np.ndarray] = []

    def least_for_the_last(_: object, __: object, genomes: np.ndarray, explanations: object) -> np.ndarray:
        asked.append(genomes)
        return np.arange(len(genomes))[::-1].astype(float)

    monkeypatch.setattr("estexp_jax.recovery.cycle.remaining_probability", least_for_the_last)
    settings = replace(job.settings, next_trial="informative", generations=3)
    *_, last = run_cycle(replace(job, settings=settings))
    bests = {row.number: row.best for row in last.history if row.phase == "exploration"}
    assert len(asked) == settings.passes - 1
    np.testing.assert_array_equal(last.controllers[1], asked[0][-1])
    assert last.simulated[1] >= 0.8 * bests[1]
    assert last.simulated[settings.passes] == bests[settings.passes]
