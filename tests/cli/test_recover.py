"""`estexp recover`, from the command line to its files."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from estexp_jax.cli.main import main

TINY = "--situation 3 --seed 1 --population 8 --generations 3 --steps 30 --settle-steps 10 --passes 2".split()
TINY.append("--no-pictures")
FILES = ("run.json", "history.parquet", "traces.npz")


def command(out: Path, *more: str) -> list[str]:
    return [sys.executable, "-m", "estexp_jax.cli.main", "recover", *TINY, "--out", str(out), *more]


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    out = tmp_path_factory.mktemp("recover") / "run"
    done = subprocess.run(command(out), capture_output=True, text=True, check=True)
    return out, done.stdout


def test_the_terminal_shows_what_happens(finished: tuple[Path, str]) -> None:
    out, shown = finished
    for part in ("planted: the part upper_", "exploration 0:", "is damaged, and walks", "diagnosis 2:", "trial 2:"):
        assert part in shown
    assert shown.strip().endswith(f"Report: {out / 'report.html'}")


def test_its_files_agree(finished: tuple[Path, str]) -> None:
    out, _ = finished
    run = json.loads((out / "run.json").read_text())
    assert list(run) == ["config", "seed", "planted", "distance", "passes", "versions"]
    assert len(run["passes"]) == 2
    assert run["passes"][-1]["diagnosis"] == run["planted"]
    with np.load(out / "traces.npz") as traces:
        assert len(traces["trial_2/time"]) == 30


def test_killed_and_resumed_it_ends_the_same(finished: tuple[Path, str], tmp_path: Path) -> None:
    out = tmp_path / "killed"
    with subprocess.Popen(command(out), stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True) as process:
        assert process.stdout is not None
        for line in process.stdout:
            if line.startswith("diagnosis 1"):
                time.sleep(0.3)
                process.send_signal(signal.SIGKILL)
                break
    assert not (out / "run.json").exists()
    resumed = subprocess.run(command(out, "--resume"), capture_output=True, text=True, check=True)
    assert "going on with pass " in resumed.stdout
    for name in FILES:
        assert (out / name).read_bytes() == (finished[0] / name).read_bytes(), name


@pytest.mark.slow  # the same in one process: tests/api/test_recover.py
def test_interrupted_it_ends_with_its_own_code(tmp_path: Path) -> None:
    with subprocess.Popen(
        command(tmp_path / "run"), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    ) as process:
        assert process.stdout is not None and process.stderr is not None
        for line in process.stdout:
            if line.startswith("exploration 0"):
                process.send_signal(signal.SIGINT)
                break
        error = process.stderr.read()
    assert process.returncode == 3
    assert "--resume" in error and "Traceback" not in error


def test_results_are_not_overwritten(finished: tuple[Path, str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["recover", *TINY, "--out", str(finished[0])]) == 2
    assert "--force" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--situation", "14"], "--situation"),
        (["--situation", "3", "--damage", "gravity_tilt angle=0.1"], "together"),
        (["--damage", "motor_weakness@knee_x loss=0.5"], "knee_f"),
        (["--steps", "10"], "--steps"),
        (["nowhere.xml"], "no such MJCF"),
    ],
)
def test_wrong_input_is_told_in_one_line(
    arguments: list[str], message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["recover", *arguments, "--out", str(tmp_path / "out")]) == 2
    error = capsys.readouterr().err
    assert message in error and "Traceback" not in error
    assert not (tmp_path / "out").exists()
