"""What the experiments of recover share."""

import json
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from estexp_jax.physics.changes import Change
from estexp_jax.recovery.state import RunState
from estexp_jax.runs.fleet import Beat
from experiments.harness.diagnosis_score import amount_error, same_set
from experiments.harness.options import Options
from experiments.harness.oracle import told
from experiments.harness.recovery_case import FIRST_SEED, Case, seeds
from experiments.harness.runs import finished, first_folder, run_all, state_of
from experiments.harness.statistics import holm, share, signed_rank
from experiments.harness.tables import read_rows, row, write_rows
from experiments.harness.world import job, quadruped
from experiments.recover.diagnosis.run import PARTS, key, published, tasks_of
from experiments.recover.oracle_diagnosis.summary import summary

WEAK = Change("motor_weakness", "hip_f", {"loss": 0.5})


def test_cases_have_folders_of_their_own() -> None:
    cases = [Case(s, seed, "quick", m) for s in range(1, 14) for seed in seeds(3) for m in ("paper", "set")]
    assert len({case.name for case in cases}) == len(cases)
    assert min(case.seed for case in cases) == FIRST_SEED


def test_a_diagnosis_is_right_where_every_change_and_place_is() -> None:
    less = Change("motor_weakness", "hip_f", {"loss": 0.53})
    assert same_set([WEAK], [less]) and not same_set([WEAK], [less, Change("gravity_tilt", None, {"angle": 0.1})])
    assert amount_error(quadruped(), [WEAK], [less]) == pytest.approx(3.0)
    assert amount_error(quadruped(), [WEAK], []) is None
    ties = [Change("tied_outputs", "hip_f", {"with": w}) for w in (2.0, 3.0)]
    assert same_set(ties[:1], ties[:1]) and not same_set(ties[:1], ties[1:])


def test_mass_errors_are_shares_of_the_nominal_mass() -> None:
    nominal = float(quadruped().model.body_mass[quadruped().index("body", "torso")])
    masses = [Change("body_mass", "torso", {"dm": x * nominal}) for x in (1.0, 0.9)]
    assert amount_error(quadruped(), masses[:1], masses[1:]) == pytest.approx(10.0)


def test_statistics() -> None:
    assert holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])
    assert signed_rank([float(i) for i in range(1, 11)], [0.0] * 10) == pytest.approx(2.0**-10)
    assert signed_rank([1.0, 1.0], [1.0, 1.0]) == 1.0
    low, high = share(9, 10)
    assert 0.6 < low < 0.9 < high < 1.0


def test_what_kills_left_half_written_goes_and_nothing_else(tmp_path: Path) -> None:
    options = Options("quick", 1, None, None, tmp_path / "table", tmp_path, publish=False)
    options.out.mkdir()
    (tmp_path / "under_way").mkdir()
    left = [options.out / ".runs.csv.elsewhere-7.part", tmp_path / "under_way" / ".run.json.elsewhere-7.part"]
    kept = [
        options.out / "runs.csv",
        options.out / "mine.part",
        tmp_path / "under_way" / ".other.json.elsewhere-8.part",
    ]
    for file in (*left, *kept):
        file.write_text("half")
    run_all([], options)
    with Beat(tmp_path / "under_way", "run"):
        pass
    assert not any(file.exists() for file in left) and all(file.exists() for file in kept)


def test_first_walks_are_shared_by_runs_on_the_same_simulators(tmp_path: Path) -> None:
    same = [Case(1, FIRST_SEED, "tiny", "set"), Case(2, FIRST_SEED, "tiny", "paper")]
    foreign = [Case(1, FIRST_SEED, "tiny", m, robot="foreign") for m in ("set", "told", "paper")]
    folders = [first_folder(case, tmp_path) for case in (*same, *foreign)]
    assert len({*folders[:2]}) == 1 == len({*folders[2:4]}) and len({*folders}) == 3


def test_a_told_run_differs_in_nothing_but_what_it_knows(tmp_path: Path) -> None:
    case = Case(1, FIRST_SEED, "tiny", "told")
    options = Options("tiny", 1, None, None, tmp_path / "table", tmp_path, publish=False)
    options.out.mkdir()
    run_all([case], options)
    state, work = state_of(case, tmp_path), job(case)
    assert state.phase == "done" and state.diagnoses == (work.planted,) * 4
    assert state.simulated[1:] == tuple(trial.distance("x") for trial in state.trials[1:])
    early = next(s for s in told(work, RunState()) if s.number == 2 and s.search is not None)
    *_, last = told(work, RunState.from_tree(early.to_tree()))
    assert all(map(np.array_equal, last.controllers, state.controllers))
    assert row(case, tmp_path)["right_4"]


def test_rows_come_back_as_they_were(tmp_path: Path) -> None:
    rows = [{"robot": "same", "seed": 6000, "right": True, "error": 0.25, "alarm": None, "rivals": "0.10 nothing"}]
    write_rows(tmp_path / "rows.csv", rows)
    assert read_rows(tmp_path / "rows.csv") == rows and read_rows(tmp_path / "none.csv") == []


def test_published_diagnoses_are_not_made_again() -> None:
    known, tasks = published(), [t for part in PARTS for t in tasks_of(part, 10)]
    assert len({key(task) for task in tasks}) == len(tasks)
    assert known and set(known) <= {key(task) for task in tasks}
    for task in tasks:
        assert [row["trials"] for row in known.get(key(task), [])] in ([], list(task.trials))


def test_ratios_are_told_by_situation() -> None:
    def pair(situation: int, before: float, damaged: float, own: float, told: float) -> tuple[dict, dict]:
        line = {"robot": "same", "situation": situation, "before": before, "damaged": damaged, "right_4": True}
        return {**line, "trial_4": own}, {**line, "trial_4": told}

    found = summary([pair(1, 2.0, 0.5, 1.0, 2.0), pair(1, 2.0, 0.9, 1.5, 1.5), pair(2, 2.0, 1.5, 1.0, 0.0)])["same"]
    assert found["situations"]["1"]["ratio"] == 0.75 and found["severe"] == {"n": 2, "twice": 1}
    assert found["situations"]["2"]["ratio"] is None, "a run that came nowhere though it was told is no measure"


def test_a_script_keeps_xlas_log_off_the_terminal(root: Path) -> None:
    clean = {k: v for k, v in os.environ.items() if k != "TF_CPP_MIN_LOG_LEVEL"}
    code = "import os, experiments.harness.options; print(os.environ['TF_CPP_MIN_LOG_LEVEL'])"
    told = subprocess.run([sys.executable, "-c", code], cwd=root, env=clean, capture_output=True, text=True, check=True)
    assert told.stdout == "3\n", "JAX, loaded first, would have set 1"


@pytest.mark.slow
def test_runs_are_resumed_and_not_repeated(tmp_path: Path) -> None:
    case = Case(3, FIRST_SEED, "quick", "set")
    options = Options("quick", 1, None, None, tmp_path / "table", tmp_path, publish=False)
    options.out.mkdir()
    run_all([case], options)
    assert finished(case, tmp_path) and state_of(case, tmp_path).phase == "done"
    before = (tmp_path / case.name / "run.json").stat().st_mtime_ns
    run_all([case], options)
    assert (tmp_path / case.name / "run.json").stat().st_mtime_ns == before
    line = row(case, tmp_path)
    assert line["right_4"] in (True, False) and line["situation"] == 3
    write_rows(tmp_path / "rows.csv", [line])
    assert (tmp_path / "rows.csv").read_text().startswith("situation,method")
    assert json.loads((tmp_path / case.name / "run.json").read_text())["seed"] == FIRST_SEED
