"""Full disks and folders that may not be written, command by command: one message, exit code 2, nothing lost."""

import json
from pathlib import Path

import pytest

from tests.cli.pendulum import EFFECT, SMALL, run

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


def _told(capsys: pytest.CaptureFixture[str]) -> str:
    """The one message on standard error, which progress shares."""
    lines = [line for line in capsys.readouterr().err.splitlines() if "error" in line or "Traceback" in line]
    [line] = lines
    assert line.startswith("estexp: error: ")
    return line


@pytest.mark.parametrize("command", ["record", "explain", "propose", "check", "recover"])
def test_a_read_only_folder_is_told(command, commands, read_only, capsys):
    assert run(*commands[command], "--out", read_only / "run") == 2
    assert str(read_only / "run") in (told := _told(capsys)) and "cannot be written" in told


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
def test_a_full_disk_is_told_and_it_goes_on_when_there_is_room(
    command, leave, commands, small_disk, request, tmp_path, capsys
):
    out = small_disk / "run"
    filler = _filled(small_disk, leave)
    assert run(*commands[command], "--out", out) == 2
    told = _told(capsys)
    assert "No space left on device" in told and "--resume" in told and str(out) in told
    assert not list(out.rglob(".*.part"))
    filler.unlink()
    assert run(*commands[command], "--out", out, "--resume") == 0
    one, other = _contents(out), _contents(_whole(command, commands, request, tmp_path))
    assert one.keys() == other.keys()
    told_apart = {name for name in one if one[name] != other[name]}
    assert told_apart <= {"findings.json", "report.html", "checkpoint.npz", "checkpoint.npz.previous"}
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
