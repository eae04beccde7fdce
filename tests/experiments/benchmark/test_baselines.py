"""Rivals read what explainers read, and the oracle with the truth beats the nominal model."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from experiments.benchmark.baselines import oracle, sparse
from experiments.benchmark.baselines.all import baselines_of
from experiments.benchmark.baselines.logs import floor, gain, nrmse, read_case, windows
from experiments.benchmark.generator.answers import answer
from experiments.benchmark.generator.case import Plan, Planted
from experiments.benchmark.generator.files import write_case
from experiments.benchmark.generator.making import make


@pytest.fixture(scope="module")
def visible(tmp_path_factory) -> tuple[Path, dict]:
    """A planar arm with plain friction at its elbow, and the answer as it comes from a file."""
    folder = tmp_path_factory.mktemp("case")
    case = make(Plan("single", "planar", (Planted("coulomb_friction", 1, 0.6),), 8), shorter=0.2, refit=False)
    write_case(case, folder)
    return folder, json.loads(json.dumps(answer(case)))


def test_the_oracle_comes_near_the_floor_and_the_nominal_model_does_not(visible):
    folder, true = visible
    model, logs = read_case(folder)
    tests = [log for log in logs if log.role == "test"]
    nominal, best, noise = nrmse(model, tests), oracle.error(true, model, tests), floor(tests)
    found = gain(best, nominal, noise)
    assert found is not None and found > 0.9


def test_a_baseline_reports_errors_gain_and_terms(visible):
    folder, true = visible
    found = baselines_of(folder, {k: v for k, v in true.items() if k != "plan"})
    assert found["nominal"]["gain"] == 0.0 and found["nominal"]["floor"] < found["nominal"]["test"]
    assert set(found["sparse"]["terms"]) == {"shoulder", "elbow"} and np.isfinite(found["sparse"]["test"])


def test_sparse_regression_finds_the_terms_that_are_there():
    rng = np.random.default_rng(0)
    q, w, tau = rng.standard_normal((3, 4000))
    force = -0.7 * np.tanh(w / 0.02) - 0.3 * w + 1e-3 * rng.standard_normal(4000)
    found = sparse.regressed(q, w, tau, force)
    assert found["sign w"] == pytest.approx(-0.7, abs=0.01) and found["w"] == pytest.approx(-0.3, abs=0.01)
    assert not any(c for t, c in found.items() if t not in ("sign w", "w"))


def test_windows_start_where_a_sensor_is_stuck_at_zero(visible):
    model, [log, *_] = read_case(visible[0])
    stuck = replace(log, sensor=np.zeros_like(log.sensor))
    for window in windows(model, stuck):
        assert not window.qpos.any() and not window.qvel.any()


def test_gain_is_beyond_noise():
    assert gain(1.0, 5.0, 1.0) == 1.0 and gain(5.0, 5.0, 1.0) == 0.0 and gain(1.0, 1.0, 1.0) is None
