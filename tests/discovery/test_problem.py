"""The comparison itself: residuals are errors, gaps count nothing, explosions count a bounded much."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import parameters_only
from tests.discovery.planted import CASES, case_of, problem_of


@pytest.fixture(scope="module")
def setting():
    robot, plant, seed = CASES["coulomb_friction@shaft"]
    case = case_of(robot, plant, seed)
    case.recordings[0].sensor[20:30] = np.nan
    problem = problem_of(case)
    hypothesis = parameters_only(case.robot, problem.replayer.catalogue)
    return case, problem, (hypothesis, hypothesis.start())


def test_squared_residuals_sum_to_the_squared_error(setting):
    case, problem, member = setting
    windows = problem.windows_of(case.indices("train"))
    assert len(windows) == 6
    total = np.sum(problem.residuals([member], windows).astype(float) ** 2)
    assert total == pytest.approx(problem.error(member, windows) ** 2, rel=1e-4)


def test_a_gap_counts_nothing_and_is_no_longer_compared(setting):
    case, problem, member = setting
    first = problem.residuals([member], problem.windows_of([0]))[0, 0]
    assert np.all(first[20:30] == 0.0) and np.all(first[31:60] != 0.0)


def test_a_simulation_that_blew_up_is_worse_than_any_but_finite(setting):
    case, problem, (hypothesis, start) = setting
    windows = problem.windows_of(case.indices("train"))
    bad = np.where([f.effect == "body_mass" for f in hypothesis.free], np.nan, start)
    residuals = problem.residuals([(hypothesis, start), (hypothesis, bad)], windows).astype(float)
    assert np.isfinite(residuals).all()
    good, blown = np.sqrt(np.sum(residuals**2, axis=(1, 2, 3)))
    assert good < 0.1 and 5.0 < blown <= 10.1


def test_the_correction_makes_a_coarse_step_as_good_as_a_fine_one(setting):
    case, problem, member = setting
    windows = problem.windows_of([0, 1])
    corrected, fine = problem.corrected_at(member), problem.exact()
    coarse_too = problem.simulated([member], windows)
    assert corrected.simulated([member], windows) == pytest.approx(
        fine.simulated([member], windows), nan_ok=True, abs=1e-6
    )
    assert np.nanmax(np.abs(coarse_too - fine.simulated([member], windows))) > 1e-3


def test_steps_are_counted(setting):
    case, problem, member = setting
    counted = replace(problem, counted=[0])
    counted.simulated([member, member], counted.windows_of([0]))
    assert counted.counted == [2 * sum(counted.segments[w].steps.n_steps for w in counted.windows_of([0]))]
