"""Logs that are wrong in meaning: cheap ones here, all in the study."""

import numpy as np
import pytest

from estexp_jax.recordings.bind import bind_columns
from estexp_jax.recordings.checks.inspect import judge
from estexp_jax.recordings.table import Table
from experiments.robustness.wrong_logs.kinds import COPIED, KINDS
from experiments.robustness.wrong_logs.robots import ROBOTS, log_of, robot_of


def test_every_kind_changes_a_log_but_that_of_a_copy():
    right = log_of("servos", np.random.default_rng(0))
    for name, kind in KINDS.items():
        wrong = kind.make(right, np.random.default_rng(1))
        same = all(len(wrong[c]) == len(right[c]) and np.array_equal(wrong[c], right[c]) for c in right)
        assert same == (name == COPIED), name


@pytest.mark.parametrize("name", ROBOTS)
def test_right_logs_are_right_without_the_model(name):
    columns = log_of(name, np.random.default_rng(2))
    assert judge(robot_of(name), bind_columns(robot_of(name), Table("a.csv", columns)), replayed=False)["faults"] == []


@pytest.mark.parametrize("kind", ["offset of a turn", "reading in degrees", "ten rows lost", "clock in ms"])
def test_some_are_named_without_the_model(kind):
    columns = KINDS[kind].make(log_of("servos", np.random.default_rng(3)), np.random.default_rng(4))
    found = judge(robot_of("servos"), bind_columns(robot_of("servos"), Table("a.csv", columns)), replayed=False)
    assert {fault["kind"] for fault in found["faults"]} & set(KINDS[kind].named)
