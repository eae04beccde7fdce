"""--out, --force and --resume: nothing is lost by accident, nothing foreign is touched."""

import json
import os
from dataclasses import dataclass

import pytest

from estexp_jax.errors import InputError
from estexp_jax.runs import open_run, save_checkpoint
from estexp_jax.runs.folder import MARKER
from estexp_jax.runs.lock import LOCK

RECOVER = {"command": "recover", "config": {"seed": 0, "damage": "a=0.5", "passes": 4}}


def _run(path):
    """A run folder with results."""
    folder = open_run(path, marker=RECOVER)
    folder.file("run.json").write_text("{}")
    folder.file("predictions/a.csv").write_text("time")
    (folder.directory("frames") / "1.png").write_text("")
    save_checkpoint(folder.file("checkpoint"), 1)
    save_checkpoint(folder.file("checkpoint"), 2)
    return folder


def _contents(path):
    return sorted(str(item.relative_to(path)) for item in path.rglob("*") if item.name != LOCK)


def test_a_new_folder_is_made_with_its_parents(tmp_path):
    folder = open_run(tmp_path / "a" / "b", marker=RECOVER)
    assert folder.path.is_dir() and not folder.resumed
    assert json.loads((folder.path / MARKER).read_text())["marker"] == RECOVER


def test_a_run_killed_before_its_marker_was_there_leaves_nothing(tmp_path):
    (tmp_path / f".{MARKER}.elsewhere-1.part").write_text("{")
    open_run(tmp_path, resume=True, marker=RECOVER)
    assert _contents(tmp_path) == [MARKER]


def test_an_empty_folder_will_do(tmp_path):
    assert open_run(tmp_path, marker=RECOVER).path == tmp_path


def test_results_are_not_overwritten(tmp_path):
    before = _contents(_run(tmp_path / "run").path)
    with pytest.raises(InputError, match="run: the folder holds results.*--force.*--resume"):
        open_run(tmp_path / "run", marker=RECOVER)
    assert _contents(tmp_path / "run") == before


def test_force_removes_what_the_run_wrote_and_nothing_else(tmp_path):
    path = _run(tmp_path / "run").path
    (path / ".checkpoint.elsewhere-1.part").write_text("left by a kill")
    (path / "notes.txt").write_text("mine")
    (path / "predictions" / "mine.csv").write_text("mine")
    folder = open_run(path, force=True, marker={"command": "recover", "config": {"seed": 1}})
    assert _contents(path) == [MARKER, "notes.txt", "predictions", "predictions/mine.csv"]
    assert folder.kept == ("notes.txt", "predictions") and not folder.resumed
    # The new run owns only what it writes itself.
    folder.file("run.json").write_text("{}")
    open_run(path, force=True, marker=RECOVER)
    assert _contents(path) == [MARKER, "notes.txt", "predictions", "predictions/mine.csv"]


@pytest.mark.parametrize("flags", [{}, {"force": True}, {"resume": True}])
def test_a_foreign_folder_is_never_touched(tmp_path, flags):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(InputError, match="not made by estexp"):
        open_run(tmp_path, **flags, marker=RECOVER)
    assert [item.name for item in tmp_path.iterdir()] == ["thesis.tex"]


@pytest.mark.parametrize(
    "text",
    ["", "{", "[]", '{"format": "estexp.run/1", "marker": {}, "written": ["../outside"]}', '{"written": ["a"]}']
    + ['{"format": "estexp.run/1", "marker": {}, "written": ["/a"]}', '{"format": "estexp.run/1", "marker": {}}']
    + [r'{"format": "estexp.run/1", "marker": {}, "written": ["a\u0000b"]}'],
)
def test_a_marker_that_is_not_ours_protects_the_folder(tmp_path, text):
    (tmp_path / "outside").write_text("mine")
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / MARKER).write_text(text)
    with pytest.raises(InputError, match="not made by estexp"):
        open_run(tmp_path / "run", force=True, marker=RECOVER)
    assert (tmp_path / "outside").exists()


def test_force_does_not_follow_links(tmp_path):
    (tmp_path / "outside").mkdir()
    (tmp_path / "outside" / "a.csv").write_text("mine")
    folder = open_run(tmp_path / "run", marker=RECOVER)
    folder.file("predictions/a.csv")
    (folder.path / "predictions").rmdir()
    (folder.path / "predictions").symlink_to(tmp_path / "outside")
    open_run(folder.path, force=True, marker=RECOVER)
    assert (tmp_path / "outside" / "a.csv").exists()


def test_resume_goes_on(tmp_path):
    before = _contents(_run(tmp_path / "run").path)
    (tmp_path / "run" / "predictions" / ".a.csv.elsewhere-1.part").write_text("left by a kill")
    folder = open_run(tmp_path / "run", resume=True, marker=RECOVER)
    assert folder.resumed and _contents(folder.path) == before
    folder.file("late.json").write_text("")
    open_run(folder.path, force=True, marker=RECOVER)
    assert _contents(folder.path) == [MARKER]


def test_resume_of_nothing_begins(tmp_path):
    assert not open_run(tmp_path / "run", resume=True, marker=RECOVER).resumed


@pytest.mark.parametrize(
    ("config", "message"),
    [
        ({"seed": 1, "damage": "a=0.5", "passes": 4}, "had config.seed = 0, not 1"),
        ({"seed": 0, "passes": 4}, 'had config.damage = "a=0.5", not absent'),
        ({"seed": 0, "damage": "a=0.5", "passes": 4, "engine": "mjx"}, 'had config.engine = absent, not "mjx"'),
        ({"seed": 0, "damage": None, "passes": 4}, 'had config.damage = "a=0.5", not null'),
        ({"seed": False, "damage": "a=0.5", "passes": 4}, "had config.seed = 0, not false"),
    ],
)
def test_resume_with_another_configuration_names_the_field(tmp_path, config, message):
    _run(tmp_path / "run")
    with pytest.raises(InputError, match="run: the run to resume " + message):
        open_run(tmp_path / "run", resume=True, marker={"command": "recover", "config": config})


def test_the_configuration_may_be_a_dataclass(tmp_path):
    @dataclass(frozen=True)
    class Options:
        seed: int
        tolerance: float

    for resume in (False, True):
        marker = {"command": "recover", "config": Options(0, 0.1 + 0.2)}
        assert open_run(tmp_path / "run", resume=resume, marker=marker).resumed is resume


def test_force_and_resume_contradict(tmp_path):
    with pytest.raises(InputError, match="--force and --resume together"):
        open_run(tmp_path, force=True, resume=True, marker=RECOVER)


def test_a_file_is_no_folder(tmp_path):
    (tmp_path / "a").write_text("")
    with pytest.raises(InputError, match="a: is a file"):
        open_run(tmp_path / "a", marker=RECOVER)
    with pytest.raises(InputError, match="cannot be written"):
        open_run(tmp_path / "a" / "b", marker=RECOVER)


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="the superuser may write anywhere")
def test_an_unwritable_folder_is_told(tmp_path):
    tmp_path.chmod(0o500)
    with pytest.raises(InputError, match="cannot be written"):
        open_run(tmp_path, marker=RECOVER)


@pytest.mark.parametrize("name", ["../a", "/a", "", ".", MARKER, LOCK])
def test_names_stay_inside(tmp_path, name):
    with pytest.raises(ValueError, match="no place inside"):
        open_run(tmp_path, marker=RECOVER).file(name)
