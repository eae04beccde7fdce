"""An experiment on a full disk, in a folder that may not be written, or beside another: told, and nothing lost."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from estexp_jax.runs.lock import lock_folder

SUBJECT = ("-m", "estexp_jax.cli.main", "experiment", "experiments/robustness/crash_recovery/subject")


def _run(root: Path, out: Path, *more: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run([sys.executable, *SUBJECT, "--out", out, *more], cwd=root, capture_output=True, text=True)


def _message(done: subprocess.CompletedProcess[str]) -> str:
    assert done.returncode == 2 and "Traceback" not in done.stderr
    [line] = [line for line in done.stderr.splitlines() if line.startswith("error: ")]
    return line


def test_a_read_only_folder_is_reported(root, read_only):
    assert "cannot be written" in _message(_run(root, read_only / "out"))


def test_a_second_process_is_refused(root, tmp_path):
    folder = tmp_path / "tiny" / "subject"
    folder.mkdir(parents=True)
    with lock_folder(folder):
        assert "is in use by process" in _message(_run(root, tmp_path))


@pytest.mark.slow
@pytest.mark.parametrize("workers", ["1", "2"])
def test_a_full_disk_is_reported_and_it_goes_on_when_there_is_room(workers, root, small_disk, tmp_path):
    filler = small_disk / "filler"
    filler.write_bytes(b"x" * (1_048_576 - 12 * 4096))
    assert "No space left on device" in _message(_run(root, small_disk, "--workers", workers))
    assert not list(small_disk.rglob("*.part"))
    filler.unlink()
    assert _run(root, small_disk, "--workers", workers).returncode == 0
    assert _run(root, tmp_path / "whole").returncode == 0
    for path in (tmp_path / "whole" / "tiny" / "runs").glob("s*/run.json"):
        one, other = (
            json.loads(each.read_text()) for each in (path, small_disk / path.relative_to(tmp_path / "whole"))
        )
        assert {name for name in one if one[name] != other[name]} <= {"wall_s", "taken_up"}
