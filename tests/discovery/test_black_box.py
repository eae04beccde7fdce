"""Replays in C are the other engines', the missing force is found, and a network learns it without exploding."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.discovery.black_box import trained
from estexp_jax.discovery.c_replay import simulated_with
from estexp_jax.discovery.findings import black_box_advice
from estexp_jax.discovery.force_residual import ForceResidual, driven, force_residuals
from estexp_jax.discovery.hypotheses import parameters_only
from tests.discovery.planted import CASES, Plant, case_of, nominal, problem_of


def nothing(qpos, qvel, ctrl, motor):
    return np.zeros_like(qvel)


def damping(qpos, qvel, ctrl, motor):
    return -0.02 * qvel


@pytest.fixture(scope="module", params=["viscous_friction@shaft", "coulomb_friction@elbow"])
def setting(request):
    """A case with motors off for a while, one with two joints; the nominal robot in C for each recording."""
    robot, plant, seed = CASES[request.param]
    case = case_of(robot, plant, seed)
    problem = problem_of(case)
    own = parameters_only(case.robot, problem.replayer.catalogue)
    return case, problem, (own, own.start()), [nominal(robot).model.__copy__() for _ in case.recordings]


def test_a_replay_without_force_is_the_nominal_simulator(setting):
    case, problem, member, models = setting
    windows = problem.windows_of([0, 3])
    found = simulated_with(problem, models, nothing, windows)
    expected = problem.exact().simulated([member], windows)[0]
    np.testing.assert_allclose(found, expected, atol=1e-3)


def test_a_law_acts_like_the_effect_that_it_is(setting):
    case, problem, (own, start), models = setting
    windows = problem.windows_of([0])
    found = simulated_with(problem, models, damping, windows)
    for model in models:
        model.dof_damping[:] += 0.02
    np.testing.assert_allclose(found, simulated_with(problem, models, nothing, windows), atol=0.02)
    for model in models:
        model.dof_damping[:] -= 0.02
    assert np.abs(found - simulated_with(problem, models, nothing, windows))[:, :100].max() > 0.05


def test_what_blows_up_is_worse_than_anything(setting):
    case, problem, member, models = setting
    windows = problem.windows_of([3])
    found = simulated_with(problem, models, lambda q, v, u, m: 1e7 * (1.0 + np.abs(v)), windows)
    assert np.isnan(found[:, :100]).any() and problem.recorded.error_of(found, windows) == np.inf


@pytest.mark.parametrize("off", [False, True])
def test_the_missing_force_is_found(off):
    case = case_of("one", Plant('damping="0.02"', 'damping="0.12"', off=off), 11, trains=1, noise=2e-5, bits=18)
    [seen] = force_residuals(problem_of(case), [nominal("one").model] * 2, [0])
    expected = -0.1 * seen.qvel[:, 0]
    error = (seen.force[:, 0] - expected)[5:-5]
    assert np.sqrt(np.mean(error**2)) < 0.15 * expected.std()


def law(rng: np.random.Generator, n: int) -> ForceResidual:
    """A force that depends on position and speed of the second joint, seen with noise."""
    q, v, u = (rng.uniform(-1.0, 1.0, (n, 2)) for _ in range(3))
    force = np.stack([np.zeros(n), np.sin(3.0 * q[:, 1]) - v[:, 1]], axis=1)
    return ForceResidual(
        np.arange(n) / 100.0, q, v, u, u, force + 0.2 * rng.standard_normal((n, 2)), u, u, np.ones_like(u)
    )


def test_a_law_is_learned_and_noise_is_not():
    rng = np.random.default_rng(5)
    network = trained(nominal("two").model, [law(rng, 1500), law(rng, 1500)], 1.0, 0)
    assert network is not None
    new = law(rng, 500)
    left = new.force - network(new.qpos, new.qvel, new.ctrl, new.motor)
    assert left.std(axis=0) == pytest.approx([0.2, 0.2], abs=0.05)


def test_the_force_stays_bounded_far_from_what_was_seen():
    rng = np.random.default_rng(6)
    seen = law(rng, 800)
    network = trained(nominal("two").model, [seen], 1.0, 0)
    assert network is not None
    far = [100.0 * x for x in (seen.qpos, seen.qvel, seen.ctrl, seen.motor)]
    assert np.abs(network(*far)).max() < 5.0 * np.abs(seen.force).max()


def test_joints_that_never_moved_get_no_force():
    seen = law(np.random.default_rng(7), 300)
    still = replace(seen, qvel=seen.qvel * [0.0, 1.0])
    assert driven(nominal("two").model, [still]).tolist() == [1]
    assert trained(nominal("two").model, [replace(seen, qvel=0.0 * seen.qvel)], 1.0, 0) is None


def test_it_predicts_better_than_parameters_alone_and_worse_than_the_truth(diagnosed):
    fit = diagnosed("coulomb_friction@shaft").findings["fit"]
    assert fit["explained"]["test"] < fit["black_box"]["test"] < 0.6 * fit["parameters_only"]["test"]


def test_it_is_offered_only_where_nothing_is_named_and_it_helps():
    fit = {"parameters_only": {"test": 0.2}, "black_box": {"test": 0.05}}
    [line] = black_box_advice("unexplained", fit)
    assert "black-box" in line and "20 %" in line and "5 %" in line
    assert black_box_advice("missing_physics", fit) == []
    assert black_box_advice("unexplained", {**fit, "black_box": {}}) == []
    assert black_box_advice("unexplained", {**fit, "black_box": {"test": np.inf}}) == []
