"""An opened set explained again: what was lost and won is told case by case, of the same recordings only."""

from dataclasses import asdict
from pathlib import Path

import pytest

from estexp_jax.errors import InputError
from experiments.benchmark import repeat
from experiments.benchmark.scoring.judge import Row
from experiments.harness.rows import write_rows
from experiments.harness.study import Study

STUDY = Study(Path("run.py"), repeat.__doc__, "repeat")

_RIGHT = {"verdict": "missing_physics", "claimed": ("armature@knee",), "detected": True, "alarm": True}
_RIGHT |= {"place_first": True, "name_first": True, "name_equivalent": True, "wrong_name": False, "gain": 0.9}
_MISSED = {"verdict": "unexplained", "detected": True, "alarm": True, "place_first": False, "name_first": False}
_MISSED |= {"name_equivalent": False, "wrong_name": False, "gain": 0.0}


def _entry(case: str, recordings: str, result: dict) -> dict:
    row = Row(case=case, group="single", robot="leg", truth="armature", shown=9.0, visible=True, **result)
    return asdict(row) | {"commit": "abcdef0123", "answer": {"effects": []}, "recordings_sha256": recordings}


@pytest.fixture
def opened(tmp_path):
    """The cases of an opened set: one found, one missed, one whose recordings are drawn otherwise today."""
    rows = [_entry("c000", "0", _RIGHT), _entry("c001", "1", _MISSED), _entry("c002", "2", _RIGHT)]
    path = tmp_path / "cases.parquet"
    write_rows(path, rows, seed=5)
    return path


def test_what_was_lost_and_won_is_reported_of_the_same_recordings(opened):
    now = [_entry("c000", "0", _MISSED), _entry("c001", "1", _RIGHT), _entry("c002", "other", _MISSED)]
    write_rows(opened.with_name("repeated.parquet"), now, seed=5)
    assert repeat.main(STUDY, [str(opened), "score", "--out", str(opened.parent)]) == 0
    lines = (opened.parent / "repeated.md").read_text(encoding="utf-8").splitlines()
    assert "at abcdef0" in lines[0] and "left out" in lines[0] and "c002" in lines[0]
    assert "| place first, effect visible | 1 of 2 | 1 of 2 |" in lines
    assert "| c000 | leg | armature | yes | armature@knee | unexplained | 0.90 | 0.00 |" in lines
    assert "| c001 | leg | armature | yes | unexplained | armature@knee | 0.00 | 0.90 |" in lines


def test_cases_that_come_out_alike_are_only_counted(opened):
    now = [_entry("c000", "0", _RIGHT)]
    write_rows(opened.with_name("repeated.parquet"), now, seed=5)
    repeat.main(STUDY, [str(opened), "score", "--out", str(opened.parent)])
    page = (opened.parent / "repeated.md").read_text(encoding="utf-8")
    assert "| place first, effect visible | 1 of 1 | 1 of 1 |" in page and "c000" not in page


def test_a_case_that_fails_now_is_lost(opened):
    failed = _entry("c000", "0", {"verdict": "none"})
    del failed["answer"], failed["recordings_sha256"]
    write_rows(opened.with_name("repeated.parquet"), [failed], seed=5)
    repeat.main(STUDY, [str(opened), "score", "--out", str(opened.parent)])
    page = (opened.parent / "repeated.md").read_text(encoding="utf-8")
    assert "| c000 | leg | armature | yes | armature@knee | none | 0.90 | - |" in page


def test_a_file_that_is_not_there_is_reported(tmp_path):
    with pytest.raises(InputError, match="none.parquet"):
        repeat.main(STUDY, [str(tmp_path / "none.parquet"), "score"])
