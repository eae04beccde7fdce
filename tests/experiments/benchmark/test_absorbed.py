"""What refitted parameters absorb is asked of `mujoco.sysid`, on the recordings that were sealed and no others."""

from pathlib import Path

import pytest

from experiments.benchmark import absorbed
from experiments.benchmark.baselines import sysid
from experiments.benchmark.generator import __main__ as writing
from experiments.benchmark.scoring.comparison import is_absorbed
from experiments.harness.rows import read_rows, write_rows
from experiments.harness.study import Study

_EFFECT = {"effect": "joint_limit", "law": None, "name": "knee"}
STUDY = Study(Path("run.py"), absorbed.__doc__, "absorbed")


def _answer(train: float, test: float, *effects: dict) -> dict:
    return {"effects": list(effects), "visibility": {"refit": {"train": train, "test": test}}}


def test_absorbed_is_an_effect_that_shows_only_in_recordings_not_fitted():
    assert is_absorbed(_answer(1.1, 9.0, _EFFECT))
    assert not is_absorbed(_answer(1.3, 9.0, _EFFECT))
    assert not is_absorbed(_answer(1.1, 2.9, _EFFECT))
    assert not is_absorbed(_answer(1.1, 9.0))


@pytest.fixture
def opened(tmp_path, monkeypatch):
    """The cases of an opened set, whose drawing is replaced."""

    def write_one(out, name, plan):
        (out / "cases" / name).mkdir(parents=True)
        (out / "cases" / name / "manifest.toml").write_text(f"# {plan.seed}", encoding="utf-8")

    monkeypatch.setattr(writing, "write_one", write_one)
    monkeypatch.setattr(sysid, "available", lambda: True)
    shared = {"robot": "leg", "truth": "joint_limit", "detected": False, "gain": 0.0, "recordings_sha256": "0"}
    answers = {"c000": _answer(1.0, 9.0, _EFFECT), "c001": _answer(5.0, 9.0, _EFFECT), "c002": _answer(1.0, 9.0)}
    rows = [{"case": case, "answer": answer} | shared for case, answer in answers.items()]
    path = tmp_path / "cases.parquet"
    write_rows(path, [*rows, {"case": "c003"} | shared], seed=5)
    return path


def test_recordings_that_were_not_sealed_are_reported_and_not_asked_about(opened):
    assert absorbed.main(STUDY, [str(opened)]) == 0
    found = read_rows(opened.with_name("absorbed.parquet"))
    assert [row["case"] for row in found] == ["c000"] and found[0]["same_recordings"] is False


def test_what_is_known_is_not_asked_again(opened):
    known = [{"case": "c000", "same_recordings": True, "sysid_noticed": True}]
    write_rows(opened.with_name("absorbed.parquet"), known)
    assert absorbed.main(STUDY, [str(opened)]) == 0
    assert read_rows(opened.with_name("absorbed.parquet")) == known


def test_without_sysid_it_says_what_is_needed(opened, monkeypatch, capsys):
    monkeypatch.setattr(sysid, "available", lambda: False)
    assert absorbed.main(STUDY, [str(opened)]) == 2
    assert "pip install" in capsys.readouterr().err


def test_a_file_that_is_not_there_is_reported(tmp_path, capsys):
    with pytest.raises(SystemExit, match="2"):
        absorbed.main(STUDY, [str(tmp_path / "none.json")])
    assert "none.json is no file" in capsys.readouterr().err
