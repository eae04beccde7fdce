"""Recordings of a robot that its simulator describes only roughly."""

from typing import Any

import numpy as np
import pytest

from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.config import Settings
from estexp_jax.recovery.estimation.choice import estimation_of
from estexp_jax.recovery.estimation.damage_sites import DamageSite
from estexp_jax.recovery.estimation.error_model import SAMPLES
from estexp_jax.recovery.estimation.genome import DamageHypothesis
from estexp_jax.recovery.estimation.likelihood import EnsembleLikelihood
from estexp_jax.recovery.estimation.method import Estimation
from estexp_jax.recovery.reality_gap_target import RealityGapTarget
from estexp_jax.recovery.simulator import DamageSimulator
from tests.recovery.estimation.lost_leg import LOST, PLANTED, OpenLoopTrials


@pytest.fixture(scope="module")
def recorded(quadruped: Robot, world: DamageSimulator, rough: Settings) -> dict[str, Any]:
    """Two trials of a robot that has lost a leg, and one before."""
    weights = np.random.default_rng(5).integers(-100, 101, (2, world.n_weights)) / 100
    before, damaged = (RealityGapTarget(quadruped, changes, 3, rough.settle_steps) for changes in ((), PLANTED))
    controllers = [world.controller(w, rough.steps) for w in weights]
    trials = [damaged(controller) for controller in controllers]
    return {"controllers": weights, "trials": trials, "healthy": [(weights[0], before(controllers[0]))]}


@pytest.fixture(scope="module")
def likelihood(world: DamageSimulator, rough: Settings, recorded: dict[str, Any]) -> EnsembleLikelihood:
    return EnsembleLikelihood(world, rough, recorded["controllers"], recorded["trials"], recorded["healthy"])


def test_the_truth_costs_about_one_a_sample_and_nothing_else_does(likelihood: EnsembleLikelihood) -> None:
    (few, misfit), (many, better) = (likelihood.evaluate(LOST, thorough=thorough) for thorough in (False, True))
    assert misfit < 2.0 and better < 2.0 and few != many
    leg, slope = (DamageSite("part_lost", "upper_f"), 1.0), (DamageSite("gravity_tilt", None), 0.5)
    others: list[DamageHypothesis] = [(), (leg,), (slope,)]
    for reference in ((), LOST):
        truth, *wrong = likelihood([LOST, *others], reference)
        assert np.all(np.array(wrong) > truth + 100.0)


def test_half_the_physics_step_is_nearer_to_a_robot_that_has_none(
    world: DamageSimulator, recorded: dict[str, Any]
) -> None:
    trials, angles = recorded["trials"], ~world.closed_loop.interface.is_touch
    measured = np.stack([trial.readings[:SAMPLES] for trial in trials])
    inputs = np.stack([trial.network_readings[:SAMPLES] for trial in trials])
    errors = {}
    for simulator in (world, world.finer):
        readings = simulator.trials([PLANTED], recorded["controllers"], measured.shape[1], inputs).readings[0]
        step = simulator.robot.model.opt.timestep
        assert step * simulator.closed_loop.substeps == pytest.approx(world.control_step)
        errors[step] = np.median(np.abs(readings - measured)[..., angles])
    assert errors[min(errors)] < 0.9 * errors[max(errors)]


def test_what_blew_up_is_never_best(likelihood: EnsembleLikelihood, monkeypatch: pytest.MonkeyPatch) -> None:
    walk = DamageSimulator.trials

    def exploding(*arguments: Any) -> Any:
        found = walk(*arguments)
        return found._replace(readings=np.full_like(found.readings, np.nan), failed=np.ones_like(found.failed))

    likelihood([()])  # the reference is judged before
    monkeypatch.setattr(DamageSimulator, "trials", exploding)
    assert likelihood([LOST])[0] == np.inf


def _run(method: Estimation, state: dict[str, Any], likelihood: EnsembleLikelihood) -> list[dict[str, Any]]:
    states = [state]
    while not method.done(states[-1]):
        states.append(method.advance(states[-1], likelihood))
    return states


@pytest.mark.slow
def test_a_lost_leg_is_among_what_noisy_recordings_name(
    world: DamageSimulator, rough: Settings, likelihood: EnsembleLikelihood
) -> None:
    method = estimation_of(world, rough, 2)
    states = _run(method, method.begin([]), likelihood)
    found = method.diagnosis(states[-1])
    assert LOST[0] in found.items  # controllers drawn at random hardly move: something may be added
    assert found.probability is not None and 0.0 < found.probability <= 1.0 and found.alarm is False
    assert _run(method, states[len(states) // 2], likelihood)[-1] == states[-1]


def test_commands_that_were_played_open_loop_are_replayed(
    world: DamageSimulator, rough: Settings, open_loop: OpenLoopTrials
) -> None:
    weights, right, wrong = open_loop
    costs = [EnsembleLikelihood(world, rough, [weights], [trial], []).evaluate(LOST)[0] for trial in (right, wrong)]
    assert costs[0] < costs[1]
