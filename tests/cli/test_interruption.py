"""Signals end a command with exit code 3, wherever it is."""

import signal
import subprocess
import sys
from pathlib import Path

import pytest

HEAD = """
import signal, sys, time
from estexp_jax.cli import commands, interruption, main as cli

def run(options):
{body}

commands._run_of = lambda options: run
commands._options_of = lambda name: type(name, (), {{"__doc__": ""}})
commands._parsed = lambda arguments: None
sys.argv[1:] = ["record"]
cli.program()
"""
WAITS = "    print('running', flush=True)\n    time.sleep(60)"
SWALLOWS = """    interruption._PATIENCE_S = 0.5
    while True:
        try:
            print('running', flush=True)
            time.sleep(60)
        except KeyboardInterrupt:
            print('swallowed', flush=True)"""
FAILS = """    try:
        print('running', flush=True)
        time.sleep(60)
    except KeyboardInterrupt:
        raise ImportError("lost on the way")"""
COMPUTES = """    import hashlib
    interruption._PATIENCE_S = 0.5
    print('running', flush=True)
    hashlib.pbkdf2_hmac('sha256', b'', b'', 2**30)  # some minutes in which no Python code runs"""
DESTROYS = """    class Slow:
        def __del__(self):
            print('running', flush=True)
            time.sleep(60)
    Slow()
    time.sleep(60)"""
HAS_DONE = """    import atexit
    atexit.register(lambda: print('running', flush=True) or time.sleep(1))
    return 0"""
LOADS = "    import a_slow_module"
HEARD = "import signal\nfor s in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP): signal.signal(s, signal.SIG_DFL)\n"
"""Signals as at a terminal, whatever the tests themselves run under."""
IGNORES = """    print('running', flush=True)
    time.sleep(1)
    return 0"""


def _end(body: str, number: int, root: Path, *, times: int = 1, first: str = "") -> tuple[int, str]:
    """Exit code and messages of a command that is sent a signal while it runs."""
    command = [sys.executable, "-c", HEARD + first + HEAD.format(body=body)]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=root, **pipes) as process:
        assert process.stdout is not None and process.stdout.readline() == "running\n"
        process.send_signal(number)
        for _ in range(times - 1):
            assert process.stdout.readline() == "swallowed\n"
            process.send_signal(number)
        _, told = process.communicate(timeout=30)
    return process.returncode, told


@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM", "SIGHUP"])
def test_every_signal_is_an_interruption(name, root):
    code, told = _end(WAITS, getattr(signal, name), root)
    assert code == 3
    assert "--resume" in told and "Traceback" not in told


def test_one_that_is_swallowed_ends_the_process_all_the_same(root):
    assert _end(SWALLOWS, signal.SIGINT, root)[0] == 3


def test_a_second_one_ends_at_once(root):
    patient = SWALLOWS.replace("0.5", "60.0")
    assert _end(patient, signal.SIGINT, root, times=2)[0] == 3


def test_an_error_that_it_leads_to_is_no_defect(root):
    code, told = _end(FAILS, signal.SIGTERM, root)
    assert code == 3
    assert "--resume" in told and "Traceback" not in told


@pytest.mark.parametrize("body", [COMPUTES, DESTROYS], ids=["compiled code", "a destructor"])
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_where_no_exception_comes_through(body, name, root):
    code, told = _end(body, getattr(signal, name), root)
    assert code == 3
    assert "--resume" in told and "Traceback" not in told


def test_what_is_done_when_it_comes_is_done(root):
    assert _end(HAS_DONE, signal.SIGTERM, root) == (0, "")


def test_next_to_nothing_is_imported_before_they_are_heard(root):
    code = "import sys, estexp_jax.cli.main; print({'inspect', 'threading', 'tyro', 'typing'} & set(sys.modules))"
    done = subprocess.run(
        [sys.executable, "-I", "-S", "-c", f"import sys; sys.path.insert(0, {str(root)!r}); {code}"],
        capture_output=True,
        text=True,
        check=True,
    )
    assert done.stdout == "set()\n"


def test_while_a_module_is_loaded(root, tmp_path):
    (tmp_path / "a_slow_module.py").write_text("import time\nprint('running', flush=True)\ntime.sleep(60)\n")
    code, told = _end(LOADS, signal.SIGINT, root, first=f"import sys; sys.path.insert(0, {str(tmp_path)!r})")
    assert code == 3
    assert "--resume" in told and "Traceback" not in told


def test_what_the_caller_ignores_stays_ignored(root):
    ignored = "import signal; signal.signal(signal.SIGHUP, signal.SIG_IGN)"
    assert _end(IGNORES, signal.SIGHUP, root, first=ignored)[0] == 0
