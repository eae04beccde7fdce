"""What values of the model would explain is taken out of residuals exactly as if they were fitted."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize

from estexp_jax.discovery.cross_validation import as_fitted, cross_validated
from estexp_jax.discovery.fitting import fit
from estexp_jax.discovery.hypotheses import claiming, parameters_only
from estexp_jax.discovery.marginal import about, slackened
from estexp_jax.discovery.selection import folds_of
from estexp_jax.discovery.slack import slack_of
from tests.discovery.planted import CASES, case_of, finished, problem_of


@pytest.fixture(scope="module")
def setting():
    robot, plant, seed = CASES["coulomb_friction@shaft"]
    case = case_of(robot, plant, seed + 400)
    problem = problem_of(case)
    parameters = parameters_only(case.robot, problem.replayer.catalogue)
    problem = problem.about((parameters, parameters.start()))
    tasks = [(h, [h.start()]) for h in (parameters, claiming(case.robot, parameters, [("coulomb_friction", "shaft")]))]
    fits = finished(fit(problem, tasks, problem.fitted, 1e-4, stage="slack", iterations=6))
    return problem, fits


def test_where_every_value_is_told_nothing_is_taken_out():
    """A manifest may tell all that could have been fitted."""
    slack = slack_of(np.zeros((3, 20, 0)), np.empty(0), np.empty(0))
    residual = np.random.default_rng(5).standard_normal((2, 3, 20))
    np.testing.assert_array_equal(slack.taken_out(residual), residual)
    assert slack.offsets(residual).shape == (2, 0)


def test_what_is_left_is_the_least_that_fitted_values_leave():
    rng = np.random.default_rng(76)
    derivative, residual = rng.standard_normal((3, 20, 4)), rng.standard_normal((3, 20)) + 0.5
    precision, offset = rng.uniform(0.5, 30.0, 4), rng.standard_normal(4)
    slack = slack_of(derivative, precision, offset)

    def cost(values):
        left = residual + derivative @ (values - offset)
        return np.sum(left**2) + np.sum(precision * values**2)

    best = minimize(cost, np.zeros(4))
    left = slack.taken_out(residual[None].astype(np.float32))
    assert np.sum(left.astype(float) ** 2) == pytest.approx(best.fun, rel=1e-4)
    assert slack.offsets(residual[None])[0] == pytest.approx(best.x, abs=1e-4)


def test_slack_leaves_what_a_fit_of_the_values_leaves(setting):
    problem, (parameters, _) = setting
    start = parameters.hypothesis.start()
    free = slackened(problem, parameters, problem.fitted, 1.0)
    whole = np.sum(problem.residuals([(parameters.hypothesis, start)], problem.fitted).astype(float) ** 2)
    left = np.sum(free.residuals([parameters.member], problem.fitted).astype(float) ** 2)
    price = problem.price_of(problem.fitted)
    prior = price * sum((v / f.spread) ** 2 for v, f in zip(parameters.vector, parameters.hypothesis.free, strict=True))
    own = np.sum(problem.residuals([parameters.member], problem.fitted).astype(float) ** 2) + prior
    assert left < whole
    assert left == pytest.approx(own, rel=0.1)


def test_held_out_windows_are_each_judged_once_and_tell_the_true_effect(setting):
    problem, fits = setting
    folds = folds_of(problem)
    parameters, true = cross_validated(problem, fits, folds)
    assert len(true.held_out) == len(problem.fitted) == sum(len(held) for _, held in folds)
    assert true.error < 0.5 * parameters.error
    [as_it_is] = as_fitted(problem, fits[1:2], folds)
    assert true.error == pytest.approx(as_it_is.error, rel=0.3)
    assert not np.array_equal(true.held_out, as_it_is.held_out)  # fitted anew without them


@pytest.mark.parametrize(("finer", "share"), [(1, 0.0), (50, 1.0)])
def test_the_robots_own_step_is_told_from_its_recordings(finer, share):
    robot, plant, seed = CASES["coulomb_friction@shaft"]
    problem = problem_of(case_of(robot, replace(plant, finer=finer), seed + 401))
    parameters = parameters_only(problem.replayer.robot, problem.replayer.catalogue)
    tasks = [(h, [h.start()]) for h in [claiming(problem.replayer.robot, parameters, [("coulomb_friction", "shaft")])]]
    begin = problem.about((parameters, parameters.start()))
    [found] = finished(fit(begin, tasks, begin.fitted, 1e-4, stage=f"step {finer}", iterations=6))
    assert about(problem, found).lacking == share
