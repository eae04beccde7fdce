"""The command itself: how it ends, what it says, how fast it starts; and what all commands do alike."""

import json
import signal
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from estexp_jax.cli import commands as cli
from estexp_jax.cli.commands import COMMANDS
from estexp_jax.cli.main import main
from estexp_jax.errors import InputError
from tests.pendulum import EFFECT, SMALL, run


@dataclass(frozen=True)
class WorkOptions:
    """Do something for a test."""

    seed: int = 0
    """Where chance begins."""


@pytest.fixture
def command(monkeypatch):
    """Let `estexp work` end as the test wants."""

    def set_run(run):
        monkeypatch.setattr(cli, "COMMANDS", ("work",))
        monkeypatch.setattr(cli, "_options_of", lambda name: WorkOptions)
        monkeypatch.setattr(cli, "_run_of", lambda options: run)

    return set_run


def _raise(error):
    raise error


def test_done_is_zero_and_options_arrive(command):
    seen = []
    command(lambda options: seen.append(options) or 0)
    assert main(["work", "--seed", "3"]) == 0
    assert seen == [WorkOptions(seed=3)]


def test_wrong_input_is_two_and_one_message(command, capsys):
    command(lambda options: _raise(InputError("no such sensor", where="a.csv, row 3", right="known are: knee")))
    assert main(["work"]) == 2
    assert capsys.readouterr() == ("", "estexp: error: a.csv, row 3: no such sensor; known are: knee\n")


def test_a_name_that_no_file_can_have_is_wrong_input(command, tmp_path, capsys):
    command(lambda options: (tmp_path / ("x" * 300)).mkdir())
    assert main(["work"]) == 2
    assert "too long for the name of a file" in capsys.readouterr().err


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
from estexp_jax.cli import commands, main as cli

def run(options):
    print("running", flush=True)
    signal.pause()

commands._run_of = lambda options: run
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


@pytest.mark.parametrize("command", ["check", "explain", "recover", "record", "bench"])
def test_every_command_refuses_models_that_read_elsewhere(arm, command, capsys):
    from tests.physics.meshes import urdf, write_box

    (arm / "robot" / "package.xml").write_text("<package/>")
    (arm / "robot" / "arm.urdf").write_text(urdf("../../secret.stl"))
    write_box(arm / "secret.stl")
    logs = ["a.csv", "b.csv"] if command in ("check", "explain") else []
    model = ["--model", "arm.urdf"] if command == "bench" else ["arm.urdf"]
    assert main([command, *model, *logs, "--out", "../out"]) == 2
    error = capsys.readouterr().err
    assert "leads out of the model's root" in error and "Traceback" not in error
    assert not (arm / "out").exists()


RECORD = ("--effect", EFFECT, "--duration", "4", "--rate", "100", "--seed", "31")
_SLOW = pytest.param("recover", 24_576, marks=pytest.mark.slow)
RECOVER = "--situation 3 --seed 1 --population 8 --generations 2 --steps 30 --settle-steps 10 --passes 1".split()


@pytest.fixture
def commands(recorded, explained) -> dict[str, tuple[object, ...]]:
    """Each command that writes a run folder, without its `--out`."""
    return {
        "record": ("record", recorded / "nominal.xml", *RECORD),
        "explain": ("explain", recorded / "recordings.toml", *SMALL),
        "propose": ("propose", explained, "--duration", "1"),
        "check": ("check", recorded / "recordings.toml"),
        "recover": ("recover", *RECOVER),
    }


def _message(capsys: pytest.CaptureFixture[str]) -> str:
    """The one message on standard error, which progress shares."""
    lines = [line for line in capsys.readouterr().err.splitlines() if "error" in line or "Traceback" in line]
    [line] = lines
    assert line.startswith("estexp: error: ")
    return line


@pytest.mark.parametrize("command", ["record", "explain", "propose", "check", "recover"])
def test_a_read_only_folder_is_refused(command, commands, read_only, capsys):
    assert run(*commands[command], "--out", read_only / "run") == 2
    assert str(read_only / "run") in (message := _message(capsys)) and "cannot be written" in message


def _filled(disk: Path, leave: int) -> Path:
    """Fill a disk but for some bytes."""
    filler, chunk = disk / "filler", b"x" * 4096
    with filler.open("wb", buffering=0) as stream:
        try:
            while True:
                stream.write(chunk)
        except OSError:
            pass
    with filler.open("rb+") as stream:
        stream.truncate(max(filler.stat().st_size - leave, 0))
    return filler


def _contents(folder: Path) -> dict[str, bytes]:
    return {
        str(p.relative_to(folder)): p.read_bytes()
        for p in folder.rglob("*")
        if p.is_file() and not p.name.startswith(".")
    }


@pytest.mark.parametrize(("command", "leave"), [("record", 12_288), ("propose", 8_192), ("explain", 24_576), _SLOW])
def test_after_a_full_disk_it_goes_on_when_there_is_room(
    command, leave, commands, small_disk, request, tmp_path, capsys
):
    out = small_disk / "run"
    filler = _filled(small_disk, leave)
    assert run(*commands[command], "--out", out) == 2
    message = _message(capsys)
    assert "No space left on device" in message and "--resume" in message and str(out) in message
    assert not list(out.rglob(".*.part"))
    filler.unlink()
    assert run(*commands[command], "--out", out, "--resume") == 0
    one, other = _contents(out), _contents(_whole(command, commands, request, tmp_path))
    assert one.keys() == other.keys()
    different = {name for name in one if one[name] != other[name]}
    assert different <= {"findings.json", "report.html", "checkpoint.npz", "checkpoint.npz.previous"}
    if command == "explain":
        first, second = (json.loads(each["findings.json"]) for each in (one, other))
        assert {name for name in first if first[name] != second[name]} <= {"cost"}


def _whole(command: str, commands, request: pytest.FixtureRequest, tmp_path: Path) -> Path:
    """The results of a run that met no full disk."""
    done = {"record": "recorded", "explain": "explained"}
    if command in done:
        return request.getfixturevalue(done[command])
    assert run(*commands[command], "--out", tmp_path / "whole") == 0
    return tmp_path / "whole"


@pytest.mark.parametrize(
    ("arguments", "suggested"),
    [
        (["explian", "a.xml", "b.csv"], "explain"),
        (["Check"], "check"),
        (["recovr"], "recover"),
        (["arm.xml", "a.csv"], "explain arm.xml a.csv"),
        (["help"], "--help"),
        (["identify"], "explain"),
    ],
)
def test_a_mistyped_command_is_told_with_the_one_that_was_meant(arguments, suggested, capsys):
    assert main(arguments) == 2
    told = capsys.readouterr().err
    assert f"did you mean `estexp {suggested}`?" in told and told.count("\n") == 1


def test_a_word_that_resembles_no_command_is_told_with_all(capsys):
    assert main(["xyzzy"]) == 2
    told = capsys.readouterr().err
    assert "did you mean" not in told and "known are: bench, check" in told
