"""What refitted parameters absorb is asked of `mujoco.sysid`, on the recordings that were sealed and no others."""

import json

import pytest

from experiments.benchmark import absorbed
from experiments.benchmark.baselines import sysid
from experiments.benchmark.generator import __main__ as writing

_EFFECT = {"effect": "joint_limit", "law": None, "name": "knee"}


def _answer(train: float, test: float, *effects: dict) -> dict:
    return {"effects": list(effects), "visibility": {"refit": {"train": train, "test": test}}}


def test_absorbed_is_an_effect_that_shows_only_in_recordings_not_fitted():
    assert absorbed.is_absorbed(_answer(1.1, 9.0, _EFFECT))
    assert not absorbed.is_absorbed(_answer(1.3, 9.0, _EFFECT))
    assert not absorbed.is_absorbed(_answer(1.1, 2.9, _EFFECT))
    assert not absorbed.is_absorbed(_answer(1.1, 9.0))


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
    path = tmp_path / "cases.json"
    path.write_text(json.dumps({"seed": 5, "rows": [*rows, {"case": "c003"} | shared]}), encoding="utf-8")
    return path


def test_recordings_that_were_not_sealed_are_told_and_not_asked_about(opened):
    assert absorbed.main([str(opened)]) == 0
    found = json.loads(opened.with_name("absorbed.json").read_text(encoding="utf-8"))
    assert list(found) == ["c000"] and found["c000"]["same_recordings"] is False


def test_what_is_known_is_not_asked_again(opened):
    known = {"c000": {"same_recordings": True, "sysid_noticed": True}}
    opened.with_name("absorbed.json").write_text(json.dumps(known), encoding="utf-8")
    assert absorbed.main([str(opened)]) == 0
    assert json.loads(opened.with_name("absorbed.json").read_text(encoding="utf-8")) == known


def test_without_sysid_it_says_what_is_needed(opened, monkeypatch, capsys):
    monkeypatch.setattr(sysid, "available", lambda: False)
    assert absorbed.main([str(opened)]) == 2
    assert "pip install" in capsys.readouterr().err


def test_a_file_that_is_not_there_is_told(tmp_path, capsys):
    with pytest.raises(SystemExit, match="2"):
        absorbed.main([str(tmp_path / "none.json")])
    assert "none.json is no file" in capsys.readouterr().err
