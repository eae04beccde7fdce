"""An opened set explained again: what was lost and won is told case by case, of the same recordings only."""

import json
from dataclasses import asdict

import pytest

from estexp_jax.errors import InputError
from experiments.benchmark import repeat
from experiments.benchmark.scoring.judge import Row

_RIGHT = {"verdict": "missing_physics", "claimed": ("armature@knee",), "detected": True, "alarm": True}
_RIGHT |= {"place_first": True, "name_first": True, "name_equivalent": True, "wrong_name": False, "gain": 0.9}
_MISSED = {"verdict": "unexplained", "detected": True, "alarm": True, "place_first": False, "name_first": False}
_MISSED |= {"name_equivalent": False, "wrong_name": False, "gain": 0.0}


def _entry(case: str, recordings: str, told: dict) -> dict:
    row = Row(case=case, group="single", robot="leg", truth="armature", shown=9.0, visible=True, **told)
    return asdict(row) | {"commit": "abcdef0123", "answer": {}, "recordings_sha256": recordings}


@pytest.fixture
def opened(tmp_path):
    """The cases of an opened set: one found, one missed, one whose recordings are drawn otherwise today."""
    rows = [_entry("c000", "0", _RIGHT), _entry("c001", "1", _MISSED), _entry("c002", "2", _RIGHT)]
    path = tmp_path / "cases.json"
    path.write_text(json.dumps({"seed": 5, "rows": rows}), encoding="utf-8")
    return path


def test_what_was_lost_and_won_is_told_of_the_same_recordings(opened):
    now = [_entry("c000", "0", _MISSED), _entry("c001", "1", _RIGHT), _entry("c002", "other", _MISSED)]
    opened.with_name("again.json").write_text(json.dumps({"seed": 5, "rows": now}), encoding="utf-8")
    assert repeat.main([str(opened), "score", "--out", str(opened.parent)]) == 0
    lines = (opened.parent / "again.md").read_text(encoding="utf-8").splitlines()
    assert "at abcdef0" in lines[0] and "left out" in lines[0] and "c002" in lines[0]
    assert "| place first, effect visible | 1 of 2 | 1 of 2 |" in lines
    assert "| c000 | leg | armature | yes | armature@knee | unexplained | 0.90 | 0.00 |" in lines
    assert "| c001 | leg | armature | yes | unexplained | armature@knee | 0.00 | 0.90 |" in lines


def test_cases_that_come_out_alike_are_only_counted(opened):
    now = [_entry("c000", "0", _RIGHT)]
    opened.with_name("again.json").write_text(json.dumps({"seed": 5, "rows": now}), encoding="utf-8")
    repeat.main([str(opened), "score", "--out", str(opened.parent)])
    page = (opened.parent / "again.md").read_text(encoding="utf-8")
    assert "| place first, effect visible | 1 of 1 | 1 of 1 |" in page and "c000" not in page


def test_a_case_that_fails_now_is_lost(opened):
    failed = _entry("c000", "0", {"verdict": "none"})
    del failed["answer"], failed["recordings_sha256"]
    opened.with_name("again.json").write_text(json.dumps({"seed": 5, "rows": [failed]}), encoding="utf-8")
    repeat.main([str(opened), "score", "--out", str(opened.parent)])
    page = (opened.parent / "again.md").read_text(encoding="utf-8")
    assert "| c000 | leg | armature | yes | armature@knee | none | 0.90 | - |" in page


def test_a_file_that_is_not_there_is_told(tmp_path):
    with pytest.raises(InputError, match="none.json"):
        repeat.main([str(tmp_path / "none.json"), "score"])
