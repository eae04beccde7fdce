"""The command itself: how it ends, what it says, how fast it starts."""

import signal
import subprocess
import sys
from dataclasses import dataclass
from types import SimpleNamespace

import pytest

from estexp_jax.cli import main as cli
from estexp_jax.cli.main import COMMANDS, main
from estexp_jax.errors import InputError


@dataclass(frozen=True)
class Options:
    """Do something for a test."""

    seed: int = 0
    """Where chance begins."""


@pytest.fixture
def command(monkeypatch):
    """Let `estexp work` end as the test wants."""

    def set_run(run):
        module = SimpleNamespace(Options=Options, run=run)
        monkeypatch.setattr(cli, "COMMANDS", ("work",))
        monkeypatch.setattr(cli, "_module", lambda name: module)
        monkeypatch.setattr(cli, "_module_of", lambda options: module)

    return set_run


def _raise(error):
    raise error


def test_done_is_zero_and_options_arrive(command):
    seen = []
    command(lambda options: seen.append(options) or 0)
    assert main(["work", "--seed", "3"]) == 0
    assert seen == [Options(seed=3)]


def test_wrong_input_is_two_and_one_message(command, capsys):
    command(lambda options: _raise(InputError("no such sensor", where="a.csv, row 3", right="known are: knee")))
    assert main(["work"]) == 2
    assert capsys.readouterr() == ("", "estexp: error: a.csv, row 3: no such sensor; known are: knee\n")


def test_interrupted_is_three_and_names_resume(command, capsys):
    command(lambda options: _raise(KeyboardInterrupt))
    assert main(["work"]) == 3
    assert "--resume" in capsys.readouterr().err


def test_a_defect_of_ours_is_not_hidden(command):
    command(lambda options: _raise(ZeroDivisionError))
    with pytest.raises(ZeroDivisionError):
        main(["work"])


@pytest.mark.parametrize("arguments", [[], ["chek"], ["check", "--outt", "a"], ["experiment"]])
def test_wrong_usage_is_two(arguments, capsys):
    assert main(arguments) == 2
    assert capsys.readouterr().err


def test_help_lists_every_command(capsys):
    assert main(["--help"]) == 0
    shown = capsys.readouterr().out
    assert all(name in shown for name in COMMANDS)


@pytest.mark.parametrize("name", COMMANDS)
def test_the_help_of_a_command_has_an_example(name, capsys):
    assert main([name, "--help"]) == 0
    shown = capsys.readouterr().out
    assert "Example:" in shown and f"estexp {name} " in shown.partition("Example:")[2]


HEAVY = "jax matplotlib mujoco pyarrow rich.progress scipy".split()


@pytest.mark.parametrize("arguments", [["--version"], ["--help"], *([name, "--help"] for name in COMMANDS)])
def test_help_imports_nothing_that_computes(arguments, root):
    code = f"""
import sys
from estexp_jax.cli.main import main
assert main({arguments!r}) == 0
heavy = [name for name in {HEAVY!r} if name in sys.modules]
print(heavy, file=sys.stderr)
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, check=True)
    assert done.stderr == "[]\n" and done.stdout


def test_version(capsys):
    assert main(["--version"]) == 0
    shown = capsys.readouterr().out
    assert shown.startswith("estexp ")
    module = [sys.executable, "-m", "estexp_jax", "--version"]
    assert subprocess.run(module, capture_output=True, text=True, check=True).stdout == shown


INTERRUPTED = """
import signal, sys
from types import SimpleNamespace
from estexp_jax.cli import main as cli
from estexp_jax.cli.experiment import Options

def run(options):
    print("running", flush=True)
    signal.pause()

cli._module_of = lambda options: SimpleNamespace(run=run)
sys.exit(cli.main(["experiment", "a"]))
"""


def test_ctrl_c_ends_cleanly(root):
    command = [sys.executable, "-c", INTERRUPTED]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen(command, cwd=root, **pipes) as process:
        assert process.stdout is not None and process.stdout.readline() == "running\n"
        process.send_signal(signal.SIGINT)
        _, told = process.communicate(timeout=20)
    assert process.returncode == 3
    assert "--resume" in told and "Traceback" not in told
