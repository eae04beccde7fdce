"""The study of signals judges endings, and sends one."""

import signal
import sys
from dataclasses import replace

import pytest

from experiments.robustness.signals.trial import Ending, signalled

WAITS = "import time; print('x', flush=True); time.sleep(60)"


def test_what_counts_as_right():
    right = Ending(came=True, code=3, took_s=1.0, traceback=False, names_resume=True, left=False, stderr="")
    assert right.is_right("SIGINT") and replace(right, code=0, names_resume=False).is_right("SIGHUP")
    for name, value in {"code": 1, "took_s": 11.0, "traceback": True, "names_resume": False, "left": True}.items():
        assert not replace(right, **{name: value}).is_right("SIGTERM"), name
    assert replace(right, code=-signal.SIGKILL).is_right("SIGKILL")


@pytest.mark.filterwarnings("ignore:os.fork:RuntimeWarning")  # JAX of other tests
def test_a_program_that_handles_nothing_is_found_out():
    ending = signalled([sys.executable, "-c", WAITS], "SIGTERM", 0.0)
    assert ending.came and ending.code == -signal.SIGTERM and not ending.is_right("SIGTERM")
