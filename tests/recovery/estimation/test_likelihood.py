"""Recordings of a robot that its simulator describes only roughly."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.control.trial import Trial
from estexp_jax.recovery.estimation.base import Estimation, MetricCost
from estexp_jax.recovery.estimation.choice import estimation_of
from estexp_jax.recovery.estimation.edits import DamageSite
from estexp_jax.recovery.estimation.error_model import SAMPLES
from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.recovery.estimation.likelihood import EnsembleLikelihood
from estexp_jax.recovery.model_error import perturbed_robots
from estexp_jax.recovery.reality_gap_target import RealityGapTarget
from estexp_jax.recovery.simulator import DamageSimulator

LOST: DamageHypothesis = ((DamageSite("part_lost", "upper_b"), 1.0),)
PLANTED = (Change("part_lost", "upper_b", {"lost": 1.0}),)


@pytest.fixture(scope="module")
def rough(settings: Settings) -> Settings:
    return replace(settings, robot="foreign")


@pytest.fixture(scope="module")
def recorded(quadruped: Robot, world: DamageSimulator, rough: Settings) -> dict[str, Any]:
    """Two trials of a robot that has lost a leg, and one before."""
    weights = np.random.default_rng(5).integers(-100, 101, (2, world.n_weights)) / 100
    before, damaged = (RealityGapTarget(quadruped, changes, 3, rough.settle_steps) for changes in ((), PLANTED))
    controllers = [world.controller(w, rough.steps) for w in weights]
    trials = [damaged(controller) for controller in controllers]
    return {"controllers": weights, "trials": trials, "healthy": [(weights[0], before(controllers[0]))]}


@pytest.fixture(scope="module")
def reproduction(world: DamageSimulator, rough: Settings, recorded: dict[str, Any]) -> EnsembleLikelihood:
    return EnsembleLikelihood(world, rough, recorded["controllers"], recorded["trials"], recorded["healthy"])


def test_an_ensemble_is_as_wrong_as_it_should_be(quadruped: Robot) -> None:
    members = perturbed_robots(quadruped, 0.03, 200)
    losses = [c.parameters["loss"] for member in members for c in member if c.effect == "motor_weakness"]
    assert np.std(losses) == pytest.approx(0.03, rel=0.1)
    assert members == perturbed_robots(quadruped, 0.03, 200)


def test_the_truth_costs_about_one_a_sample_and_nothing_else_does(reproduction: EnsembleLikelihood) -> None:
    (few, misfit), (many, surer) = (reproduction.evaluate(LOST, thorough=thorough) for thorough in (False, True))
    assert misfit < 2.0 and surer < 2.0 and few != many
    others: list[DamageHypothesis] = [
        (),
        ((DamageSite("part_lost", "upper_f"), 1.0),),
        ((DamageSite("gravity_tilt", None), 0.5),),
    ]
    for about in ((), LOST):
        truth, *wrong = reproduction([LOST, *others], about)
        assert np.all(np.array(wrong) > truth + 100.0)


def test_half_the_physics_step_is_nearer_to_a_robot_that_has_none(
    world: DamageSimulator, recorded: dict[str, Any]
) -> None:
    trials, angles = recorded["trials"], ~world.closed_loop.interface.is_touch
    seen = np.stack([trial.readings[:SAMPLES] for trial in trials])
    heard = np.stack([trial.network_readings[:SAMPLES] for trial in trials])
    off = {}
    for simulator in (world, world.finer):
        readings = simulator.trials([PLANTED], recorded["controllers"], seen.shape[1], heard).readings[0]
        step = simulator.robot.model.opt.timestep
        assert step * simulator.closed_loop.substeps == pytest.approx(world.control_step)
        off[step] = np.median(np.abs(readings - seen)[..., angles])
    assert off[min(off)] < 0.9 * off[max(off)]


def test_what_blew_up_is_never_best(reproduction: EnsembleLikelihood, monkeypatch: pytest.MonkeyPatch) -> None:
    walk = DamageSimulator.trials

    def exploding(*arguments: Any) -> Any:
        found = walk(*arguments)
        return found._replace(readings=np.full_like(found.readings, np.nan), failed=np.ones_like(found.failed))

    reproduction([()])  # the reference is judged before
    monkeypatch.setattr(DamageSimulator, "trials", exploding)
    assert reproduction([LOST])[0] == np.inf


def _run(method: Estimation, state: dict[str, Any], reproduction: EnsembleLikelihood) -> list[dict[str, Any]]:
    states = [state]
    while not method.done(states[-1]):
        states.append(method.advance(states[-1], reproduction))
    return states


@pytest.mark.slow
def test_a_lost_leg_is_among_what_noisy_recordings_name(
    world: DamageSimulator, rough: Settings, reproduction: EnsembleLikelihood
) -> None:
    method = estimation_of(world, rough, 2)
    states = _run(method, method.begin([]), reproduction)
    found = method.diagnosis(states[-1])
    assert LOST[0] in found.items  # controllers drawn at random hardly move: something may be added
    assert found.probability is not None and 0.0 < found.probability <= 1.0 and found.alarm is False
    assert _run(method, states[len(states) // 2], reproduction)[-1] == states[-1]


@pytest.mark.parametrize("paper", [False, True], ids=["rough", "paper"])
def test_commands_that_were_played_open_loop_are_replayed(paper: bool, world: DamageSimulator, rough: Settings) -> None:
    weights = np.random.default_rng(5).integers(-100, 101, world.n_weights) / 100
    foretold = world.trial((), weights, rough.steps)
    walk = world.trials([PLANTED], weights[None], rough.steps, foretold.readings[None])
    np.testing.assert_array_equal(walk.commands[0, 0], foretold.commands)
    deaf = Trial(foretold.time, walk.readings[0, 0], foretold.commands, walk.position[0, 0])
    settings, costs = replace(rough, paper=paper), []
    for trial in (replace(deaf, open_loop_readings=foretold.readings), deaf):
        args = (world, settings, [weights], [trial])
        residuals = MetricCost(*args) if paper else EnsembleLikelihood(*args, healthy=[])
        costs.append(residuals.evaluate(LOST)[0])
    assert costs[0] < costs[1] and (costs[0] == 0.0 or not paper)
