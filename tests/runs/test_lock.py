"""Two processes on one run folder: the second is refused, and a dead one holds nothing."""

import signal
import subprocess
import sys
import threading
import time

import pytest

from estexp_jax.errors import InputError
from estexp_jax.runs import open_run
from estexp_jax.runs.lock import LOCK, lock_folder

OTHER = """
import sys, time
from estexp_jax.runs import open_run
folder = open_run(sys.argv[1], resume=True, marker={"seed": 0})
print("at work", flush=True)
time.sleep(60)
"""


@pytest.fixture
def other(tmp_path, root):
    """Another process at work in a run folder."""
    command = [sys.executable, "-c", OTHER, str(tmp_path / "run")]
    with subprocess.Popen(command, cwd=root, stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "at work\n"
        yield process
        process.kill()


@pytest.mark.parametrize("flags", [{}, {"force": True}, {"resume": True}])
def test_the_second_is_refused(other, tmp_path, flags):
    with pytest.raises(InputError, match=f"run: is in use by process {other.pid} on .*another folder"):
        open_run(tmp_path / "run", **flags, marker={"seed": 0})


def test_a_killed_one_holds_nothing(other, tmp_path):
    other.send_signal(signal.SIGKILL)
    other.wait()
    assert open_run(tmp_path / "run", resume=True, marker={"seed": 0}).resumed


def test_a_patient_one_gets_it_after_the_first(other, tmp_path):
    threading.Timer(0.5, other.kill).start()
    begin = time.monotonic()
    assert open_run(tmp_path / "run", resume=True, marker={"seed": 0}, patience=30).resumed
    assert time.monotonic() - begin >= 0.4


def test_one_process_may_ask_twice(tmp_path):
    first = lock_folder(tmp_path)
    assert lock_folder(tmp_path) is first


def test_a_lock_in_a_folder_that_was_removed_counts_no_more(tmp_path):
    first = lock_folder(tmp_path)
    (tmp_path / LOCK).unlink()
    assert lock_folder(tmp_path) is not first
