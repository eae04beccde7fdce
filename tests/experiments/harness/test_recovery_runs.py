"""Runs of a list of cases: shared first walks, resumed where they were, not repeated."""

import json
from pathlib import Path

import pytest

from estexp_jax.runs.fleet import Heartbeat
from experiments.harness.options import Options
from experiments.harness.recovery_case import FIRST_SEED, RecoveryCase
from experiments.harness.recovery_rows import row
from experiments.harness.recovery_runs import each_kept, finished, first_folder, kept, run_cases, state_of
from experiments.harness.rows import read_rows, write_rows


def test_what_kills_left_half_written_goes_and_nothing_else(tmp_path: Path) -> None:
    options = Options("quick", 1, None, None, tmp_path / "table", tmp_path)
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
    run_cases([], options)
    with Heartbeat(tmp_path / "under_way", "run"):
        pass
    assert not any(file.exists() for file in left) and all(file.exists() for file in kept)


def test_first_walks_are_shared_by_runs_on_the_same_simulators(tmp_path: Path) -> None:
    same = [RecoveryCase(1, FIRST_SEED, "tiny", "set"), RecoveryCase(2, FIRST_SEED, "tiny", "paper")]
    foreign = [RecoveryCase(1, FIRST_SEED, "tiny", m, robot="foreign") for m in ("set", "oracle", "paper")]
    folders = [first_folder(case, tmp_path) for case in (*same, *foreign)]
    assert len({*folders[:2]}) == 1 == len({*folders[2:4]}) and len({*folders}) == 3


def test_what_is_kept_is_not_done_again(tmp_path: Path) -> None:
    options = Options("quick", 1, None, None, tmp_path / "table", tmp_path)
    options.out.mkdir()
    calls = {tmp_path / "cases" / f"{i}.json": (divmod, i, 2) for i in (7, 8)}
    (tmp_path / "cases").mkdir()
    (tmp_path / "cases" / "7.json").write_text("[0, 0]")
    each_kept("cases", calls, options)
    assert [kept(path) for path in calls] == [[0, 0], [4, 0]] and kept(tmp_path / "none.json") is None


@pytest.mark.slow
def test_runs_are_resumed_and_not_repeated(tmp_path: Path) -> None:
    case = RecoveryCase(3, FIRST_SEED, "quick", "set")
    options = Options("quick", 1, None, None, tmp_path / "table", tmp_path)
    options.out.mkdir()
    run_cases([case], options)
    assert finished(case, tmp_path) and state_of(case, tmp_path).phase == "done"
    before = (tmp_path / case.name / "run.json").stat().st_mtime_ns
    run_cases([case], options)
    assert (tmp_path / case.name / "run.json").stat().st_mtime_ns == before
    line = row(case, tmp_path)
    assert line["right_4"] in (True, False) and line["situation"] == 3
    write_rows(tmp_path / "rows.parquet", [line])
    assert read_rows(tmp_path / "rows.parquet") == [line]
    assert json.loads((tmp_path / case.name / "run.json").read_text())["seed"] == FIRST_SEED
