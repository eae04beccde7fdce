"""A sealed set in parts: everything but its results is frozen, and nobody looks before it is whole."""

import json
import subprocess
from dataclasses import asdict

import pytest

from estexp_jax.errors import InputError
from experiments.benchmark import outside_catalogue, sealed
from experiments.benchmark.on_disk import FULL
from experiments.benchmark.scoring.judge import Row
from experiments.benchmark.sets import frozen_commit, seed_of
from experiments.harness.rows import write_rows

_EFFECT = {"effect": "armature", "law": None, "name": "knee"}


@pytest.fixture
def repository(tmp_path):
    """One with a commit."""
    for arguments in (("init", "-q"), ("config", "user.email", "a@b.c"), ("config", "user.name", "a")):
        subprocess.run(["git", "-C", str(tmp_path), *arguments], check=True)
    (tmp_path / "code.py").write_text("x = 1\n", encoding="utf-8")
    subprocess.run(["git", "-C", str(tmp_path), "add", "."], check=True)
    subprocess.run(["git", "-C", str(tmp_path), "commit", "-qm", "one"], check=True)
    return tmp_path


def _entry(case: str, **what) -> dict:
    row = Row(
        **{"case": case, "group": "single", "robot": "leg", "truth": "armature", "shown": 9.0, "visible": True} | what
    )
    refit = {"train": 1.0, "test": 9.0}
    answer = {"effects": [_EFFECT], "visibility": {"refit": refit}}
    return asdict(row) | {"commit": "c0", "answer": answer, "baselines": None}


def test_results_may_grow_while_everything_else_is_frozen(repository, monkeypatch):
    published = repository / "sealed.parquet"
    commit = frozen_commit(repository)
    write_rows(published, [{"commit": commit}], seed=seed_of(commit))
    monkeypatch.setattr(sealed, "ROOT", repository)
    assert sealed.sealed_seed(published) == seed_of(commit)
    write_rows(published, [{"commit": "abc"}], seed=1)
    with pytest.raises(InputError, match="sealed at abc"):
        sealed.sealed_seed(published)
    (repository / "code.py").write_text("x = 2\n", encoding="utf-8")
    with pytest.raises(InputError, match="commit everything first"):
        sealed.sealed_seed(published)


def test_a_set_is_opened_only_when_it_is_whole(tmp_path):
    log = tmp_path / "openings.jsonl"
    found = _entry("c000", verdict="missing_physics", claimed=("armature@knee",), detected=True, place_first=True)
    baselines = {"oracle": {"gain": 0.9}, "sysid": {"gain": 0.1, "noticed": False}}
    found |= {"gain": 0.8, "errors": {"nominal": 1.0, "explained": 0.2}, "floor": 0.01, "baselines": baselines}
    failed = _entry("c001", verdict="none")
    del failed["answer"], failed["baselines"]
    with pytest.raises(InputError, match="1 of 2 cases"):
        sealed.opened(log, tmp_path, [found], 2)
    with pytest.raises(InputError, match="2 commits"):
        sealed.opened(log, tmp_path, [found, failed | {"commit": "c1"}], 2)
    page = sealed.opened(None, tmp_path, [found, failed], 2).read_text(encoding="utf-8")
    assert "development set" in page and not log.exists(), "only sealed sets are spent"
    page = sealed.opened(log, tmp_path, [found, failed], 2).read_text(encoding="utf-8")
    assert "2 of 2 cases (sealed at commit c0" in page and "| c001 | leg | single | armature |" in page
    assert "mujoco.sysid in 0 of 1" in page
    assert json.loads(log.read_text(encoding="utf-8"))["commit"] == "c0"


def test_baselines_get_a_hundred_cases_that_the_seed_draws():
    one, other = sealed.with_baselines(5), sealed.with_baselines(6)
    assert len(one) == len(other) == 100 and one != other
    assert one <= {f"c{i:03d}" for i in range(FULL)}
    groups = [plan.group for plan in sealed.planned(5, "all")]
    assert len(groups) >= 400 and sum(g in ("null", "parameters") for g in groups) >= 150


def test_laws_outside_the_catalogue_are_drawn_as_in_a_set_of_all_groups_and_scored_without_baselines(tmp_path):
    drawn = outside_catalogue.planned(5, "all")
    assert {plan.group for plan in drawn} == {"unknown", "relative"} and len(drawn) >= 80
    shared = {"group": "unknown", "truth": "eddy", "errors": {"nominal": 1.0, "explained": 0.2}, "floor": 0.01}
    rows = [_entry("c000", verdict="unexplained", detected=True, place_first=True, wrong_name=False, **shared)]
    rows += [_entry("c001", verdict="missing_physics", claimed=("armature@knee",), wrong_name=True, gain=0.8, **shared)]
    log = tmp_path / "openings.jsonl"
    page = sealed.opened(log, tmp_path, rows, 2).read_text(encoding="utf-8")
    assert "| laws in no catalogue: wrong name | 50.0 %" in page and (tmp_path / "scored" / "scores.png").is_file()
    assert json.loads(log.read_text(encoding="utf-8"))["scores"]["wrong_name_outside_catalogue"]["k"] == 1
