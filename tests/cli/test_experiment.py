"""estexp experiment: finds the folder, runs it, and ends as it ends."""

import json

import pytest

from estexp_jax.cli.main import main

RUN = """
import json, os, signal, sys
json.dump([sys.argv[1:], sys.executable], open("seen.json", "w"))
{end}
"""


@pytest.fixture
def experiments(tmp_path, monkeypatch):
    """Write experiments into the current folder, each with an end of its own."""
    monkeypatch.chdir(tmp_path)

    def write(name, end="", folder="experiments"):
        (tmp_path / folder / name).mkdir(parents=True)
        (tmp_path / folder / name / "run.py").write_text(RUN.format(end=end))
        return tmp_path / folder / name

    (tmp_path / "experiments" / "notebooks").mkdir(parents=True)
    return write


def _seen(tmp_path):
    return json.loads((tmp_path / "seen.json").read_text())[0]


def test_it_runs_with_what_was_asked_for(experiments, tmp_path):
    experiments("knee")
    assert main(["experiment", "knee"]) == 0
    assert _seen(tmp_path) == []
    assert main(["experiment", "knee", "--quick", "--resume", "--workers", "2"]) == 0
    assert _seen(tmp_path) == ["--quick", "--resume", "--workers", "2"]


def test_a_path_will_do(experiments, tmp_path):
    folder = experiments("mine", folder="elsewhere")
    assert main(["experiment", str(folder)]) == 0 and _seen(tmp_path) == []


@pytest.mark.parametrize(
    ("end", "code"),
    [
        ("sys.exit(2)", 2),
        ("sys.exit(3)", 3),
        ("raise ValueError", 1),
        ("signal.signal(signal.SIGINT, signal.SIG_DFL); os.kill(os.getpid(), signal.SIGINT)", 3),
        ("os.kill(os.getpid(), signal.SIGKILL)", 1),
    ],
)
def test_its_exit_code_is_ours(experiments, capfd, end, code):
    experiments("knee", end)
    assert main(["experiment", "knee"]) == code
    assert ("killed by SIGKILL" in capfd.readouterr().err) == ("SIGKILL" in end)


def test_an_unknown_one_is_told_with_those_that_exist(experiments, capsys):
    experiments("knee")
    experiments("ankle")
    assert main(["experiment", "hip"]) == 2
    assert "no experiment 'hip'" in (told := capsys.readouterr().err) and "known are: ankle, knee" in told
    assert main(["experiment", "notebooks"]) == 2


def test_a_study_of_a_group_runs_by_its_name_with_or_without_the_group(experiments, tmp_path):
    experiments("planted", folder="experiments/explain")
    for name in ("planted", "explain/planted", "experiments/explain/planted"):
        (tmp_path / "seen.json").unlink(missing_ok=True)
        assert main(["experiment", name]) == 0 and _seen(tmp_path) == [], name


def test_a_name_that_two_groups_have_needs_its_group(experiments, tmp_path, capsys):
    experiments("knee", folder="experiments/explain")
    experiments("knee", folder="experiments/recover")
    assert main(["experiment", "knee"]) == 2
    assert "explain/knee, recover/knee" in capsys.readouterr().err
    assert main(["experiment", "recover/knee"]) == 0 and _seen(tmp_path) == []
    assert main(["experiment", "hip"]) == 2
    assert "explain/knee" in capsys.readouterr().err


def test_workers_are_at_least_one(experiments, capsys):
    experiments("knee")
    assert main(["experiment", "knee", "--workers", "0"]) == 2
    assert "--workers" in capsys.readouterr().err


def test_ray_and_the_folder_are_handed_on(experiments, tmp_path, monkeypatch):
    experiments("knee")
    monkeypatch.setattr("estexp_jax.runs.cluster.find_spec", lambda name: name)
    assert main(["experiment", "knee", "--ray", "--out", "shared"]) == 0
    assert _seen(tmp_path) == ["--ray", "--out", "shared"]
    assert main(["experiment", "knee", "--ray", "10.0.0.1:6379"]) == 0
    assert _seen(tmp_path) == ["--ray", "10.0.0.1:6379"]


def test_without_ray_the_command_that_installs_it_is_told(experiments, monkeypatch, capsys):
    experiments("knee")
    monkeypatch.setattr("estexp_jax.runs.cluster.find_spec", lambda name: None)
    assert main(["experiment", "knee", "--ray"]) == 2
    assert "pip install 'estexp_jax[cluster]'" in capsys.readouterr().err


def test_one_cluster_at_a_time(experiments, capsys):
    experiments("knee")
    assert main(["experiment", "knee", "--ray", "a:1", "b:2"]) == 2
    assert "2 addresses" in capsys.readouterr().err
