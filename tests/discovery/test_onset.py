"""A mismatch that begins part-way is dated; one that is there from the start, or in one recording only, is not."""

from dataclasses import fields, replace

import numpy as np
import pytest

from estexp_jax.discovery.force_residual import ForceResidual
from estexp_jax.discovery.hypotheses import claiming, parameters_only
from estexp_jax.discovery.onset import helps_before, onsets
from estexp_jax.discovery.slopes import Fit
from tests.discovery.planted import CASES, case_of, problem_of

BEGAN = {0: 3.1, 1: 4.4, 2: 5.0}


def lacking(seed: int, began: float, size: float = 0.5) -> ForceResidual:
    """A joint that lacks Coulomb friction from some time on; small errors of parameters all along."""
    rng, time = np.random.default_rng(seed), np.arange(800) / 100.0
    w = np.sin(2.0 * np.pi * rng.uniform(0.3, 1.2, (3, 1)) * time + rng.uniform(0.0, 6.3, (3, 1))).sum(axis=0)
    other = 0.1 * w + 0.05 * rng.standard_normal(800)
    force = np.stack([other, other - size * np.sign(w) * (time >= began)], axis=1)
    table = np.stack([w, w], axis=1)
    return ForceResidual(time, table, table, table, table, force, table, table, np.ones_like(table))


def test_an_onset_is_dated_in_each_recording():
    found = onsets({i: lacking(i, t) for i, t in BEGAN.items()}, [0, 1], 0)
    assert found == pytest.approx(BEGAN, abs=0.3)


def test_from_the_start_is_no_onset():
    assert onsets({i: lacking(i, -1.0) for i in range(3)}, [0, 1], 0) == {}
    assert onsets({i: lacking(i, 9.0) for i in range(3)}, [0, 1], 0) == {}


def test_one_recording_of_three_is_not_enough_but_one_of_one_is():
    assert onsets({0: lacking(0, 3.1), 1: lacking(1, -1.0), 2: lacking(2, -1.0)}, [0, 1], 0) == {}
    assert onsets({0: lacking(0, 3.1)}, [0, 1], 0) == pytest.approx({0: 3.1}, abs=0.1)


def test_short_or_silent_recordings_tell_nothing():
    r = lacking(0, 1.0)
    short = ForceResidual(*(getattr(r, f.name)[:60] for f in fields(r)))
    assert onsets({0: short}, [0, 1], 0) == {}
    assert onsets({0: replace(r, force=0.0 * r.force)}, [0, 1], 0) == {}
    assert onsets({0: r}, [], 0) == {}


def test_an_effect_that_is_there_all_along_helps_before():
    robot, plant, seed = CASES["coulomb_friction@shaft"]
    case = case_of(robot, plant, seed)
    problem = problem_of(case)
    own = parameters_only(case.robot, problem.replayer.catalogue)
    hypothesis = claiming(case.robot, own, [("coulomb_friction", "shaft")])
    right = Fit(hypothesis, hypothesis.with_values(("coulomb_friction", "shaft"), [0.15]), 1.0)
    wrong = Fit(hypothesis, hypothesis.with_values(("coulomb_friction", "shaft"), [1.5]), 1.0)
    assert helps_before(problem, {0: 1.4, 1: 1.4}, right)
    assert not helps_before(problem, {0: 1.4, 1: 1.4}, wrong)
    assert not helps_before(problem, {0: 0.3}, right)  # no window ends before


def test_findings_tell_when(diagnosed):
    wrong, right = (diagnosed(name).findings["when"] for name in ("coulomb_friction@shaft", "nothing"))
    names = {f"train_{k}.csv": None for k in (700, 701, 702)}
    assert wrong["onset_s"] == names and wrong["regime"].endswith(("of shaft", "throughout"))
    assert right["regime"] is None and set(right["onset_s"].values()) == {None}
