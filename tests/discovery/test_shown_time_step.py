"""The step at which an explained simulator is shown."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import parameters_only
from estexp_jax.discovery.shown_time_step import resolved, step_error
from tests.discovery.planted import CASES, case_of, problem_of


@pytest.fixture(scope="module")
def setting():
    case = case_of(*CASES["coulomb_friction@shaft"])
    problem = problem_of(case)
    hypothesis = parameters_only(case.robot, problem.replayer.catalogue)
    return case, problem, (hypothesis, hypothesis.start())


def quieter(problem, by):
    return replace(problem, noise=problem.noise / by)


def test_the_error_is_what_half_and_all_of_a_step_differ_by_twice(setting):
    _, problem, member = setting
    half = problem.replays.readings([member], problem.fitted, problem.replays.cut.half)[0]
    whole = problem.replays.readings([member], problem.fitted, problem.segments)[0]
    moved = 2.0 * (half - whole) / problem.recorded.deviation(problem.fitted, 1)
    assert step_error(problem, member) == pytest.approx(np.median(np.sqrt(np.nanmean(moved**2, axis=(1, 2)))), rel=0.1)
    assert step_error(quieter(problem, 10.0), member) == pytest.approx(10.0 * step_error(problem, member), rel=1e-3)


def test_the_less_noise_the_finer_and_as_fine_as_a_robot_that_was_simulated(setting):
    case, problem, member = setting
    own = step_error(problem, member)
    shown = [resolved(case, quieter(problem, k * own**-1), problem, member).replays.cut for k in (1.9, 3.9, 99.0)]
    assert [cut.parts for cut in shown] == [4, 8, 16]
    for cut in shown:
        steps = {len(cut.fine[w].steps.start) / len(cut.whole[w].steps.start) for w in range(len(cut.whole))}
        assert steps == {cut.parts}
        assert cut.exact().whole == cut.fine
    coarse = replace(quieter(problem, 99.0), lacking=0.75)
    assert resolved(case, coarse, problem, member).replays.cut.parts == 4
