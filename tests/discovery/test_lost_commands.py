"""A command that jumped while the logger lost rows is put where readings show that it acted."""

from dataclasses import replace

import numpy as np
import pytest

from estexp_jax.discovery.hypotheses import parameters_only
from estexp_jax.discovery.lost_commands import commanded
from tests.discovery.planted import CASES, case_of, problem_of


def without_rows(recording, rows):
    kept = np.setdiff1d(np.arange(recording.rows), rows)
    tables = {name: getattr(recording, name)[kept] for name in ("time", "ctrl", "enable", "sensor", "qpos", "qvel")}
    return replace(recording, **tables)


@pytest.mark.parametrize("first", [0, -3])
def test_a_jump_beside_lost_rows_is_put_where_it_acted(first):
    robot, plant, seed = CASES["nothing"]
    case = case_of(robot, plant, seed + 500)
    whole = case.recordings[0]
    jump = 1 + int(np.argmax(np.abs(np.diff(whole.ctrl[:, 0]))))
    lost = jump + first + np.arange(3)  # all after the jump, or all before it
    case = replace(case, recordings=(without_rows(whole, lost), *case.recordings[1:]))
    problem = problem_of(case)
    parameters = parameters_only(case.robot, problem.replayer.catalogue)
    found = commanded(problem, (parameters, parameters.start()))
    size = abs(whole.ctrl[jump, 0] - whole.ctrl[jump - 1, 0])
    assert size > 0.2
    off = [np.abs(p.recordings[0].ctrl[lost, 0] - whole.ctrl[lost, 0]) for p in (problem, found)]
    assert off[0].max() > 0.5 * size
    assert off[1].max() < 0.3 * size
    for before, after in zip(problem.recordings[1:], found.recordings[1:], strict=True):
        np.testing.assert_array_equal(before.ctrl, after.ctrl)


def test_nothing_lost_nothing_changed():
    robot, plant, seed = CASES["nothing"]
    problem = problem_of(case_of(robot, plant, seed + 501))
    parameters = parameters_only(problem.replayer.robot, problem.replayer.catalogue)
    assert commanded(problem, (parameters, parameters.start())) is problem
