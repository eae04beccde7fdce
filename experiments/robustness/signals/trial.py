"""One command that is sent a signal, and the same command gone on with: how each ends, and with which results."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, final

from experiments.robustness.crash_recovery import subjects
from experiments.robustness.crash_recovery.trial import spent

COMMANDS = ("explain", "recover", "check", "propose")
SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP", "SIGKILL")
_LOOK_S = 0.02
_PATIENCE_S = 60.0
"""After which a command that a signal has not ended is killed."""


@final
@dataclass(frozen=True)
class Ending:
    """How a command ended.

    Attributes:
        came: whether it was still running when the signal was sent.
        code: its exit code; negative: the signal that killed it.
        took_s: from the signal to the end.
        traceback: whether it showed one.
        names_resume: whether its message says how to go on.
        left: whether processes of it were still alive.
        stderr: the end of what it said.
    """

    came: bool
    code: int
    took_s: float
    traceback: bool
    names_resume: bool
    left: bool
    stderr: str

    def is_right(self, name: str) -> bool:
        """Whether it is as promised, for a signal of this name."""
        if name == "SIGKILL":
            return self.code in (0, -signal.SIGKILL)
        told = self.code == 0 or self.names_resume
        return self.code in (0, 3) and told and self.took_s <= 10.0 and not (self.traceback or self.left)


def line(command: str, inputs: Path, out: Path) -> list[str]:
    """The command line; with `--resume` it goes on, and begins where there is nothing."""
    if command in subjects.COMMANDS:
        return [*subjects.line(command, inputs, out), "--no-pictures"]
    read = {"check": str(inputs / "recordings.toml"), "propose": str(inputs.parent / "reference" / "explain")}
    return [*subjects.ESTEXP, command, read[command], "--out", str(out), "--resume"]


def whole(command: str, inputs: Path, out: Path) -> float:
    """A run without a signal: the processor time that it took, s."""
    shutil.rmtree(out, ignore_errors=True)
    nowhere, took = subprocess.DEVNULL, 0.0
    process = subprocess.Popen(line(command, inputs, out), stdout=nowhere, stderr=nowhere)
    while process.poll() is None:
        took = max(took, spent(process.pid))
        time.sleep(_LOOK_S)
    if process.returncode:
        raise RuntimeError(f"{command} ends with {process.returncode}")
    return took


def interrupted(command: str, name: str, at: float, inputs: Path, reference: Path | None, out: Path) -> dict[str, Any]:
    """A command that is sent a signal, and then gone on with to the end.

    Args:
        command: which.
        name: of the signal. SIGINT and SIGHUP go to all of its processes, as a terminal sends them.
        at: when, s of its processor time, so that a busy machine draws the same moments.
        inputs: what it reads.
        reference: results of a run without a signal; None: it is not gone on with.
        out: its folder; emptied.
    """
    shutil.rmtree(out, ignore_errors=True)
    ending = signalled(line(command, inputs, out), name, at)
    found = {"command": command, "signal": name, "at_cpu_s": at, **asdict(ending), "right": ending.is_right(name)}
    if reference is None:
        return {**found, "again": None, "differs": []}
    again = subprocess.run(line(command, inputs, out), check=False, capture_output=True, text=True)
    told = "" if again.returncode == 0 else again.stderr[-2000:]
    differs = subjects.differences(reference, out)
    return {**found, "again": again.returncode, "again_stderr": told, "differs": differs}


def signalled(arguments: list[str], name: str, at: float) -> Ending:
    """Start a program, send it a signal at a processor time, s, and see how it ends."""
    number = getattr(signal, name)
    process = subprocess.Popen(
        arguments,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        start_new_session=True,
        preexec_fn=_heard,  # noqa: PLW1509 (nothing else runs in this process)
    )
    while process.poll() is None and spent(process.pid) < at:
        time.sleep(_LOOK_S)
    came, begin = process.poll() is None, time.monotonic()
    if came:
        (os.kill if name == "SIGTERM" else os.killpg)(process.pid, number)
    try:
        _, told = process.communicate(timeout=_PATIENCE_S)
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        _, told = process.communicate()
    took = time.monotonic() - begin
    left = _alive(process.pid)
    if left:
        os.killpg(process.pid, signal.SIGKILL)
    told_resume = "--resume" in told
    return Ending(came, process.returncode, took, "Traceback" in told, told_resume, left, told[-2000:])


def _heard() -> None:
    """In the child: signals as at a terminal, whatever this study runs under."""
    for name in SIGNALS[:3]:
        signal.signal(getattr(signal, name), signal.SIG_DFL)


def _alive(group: int) -> bool:
    """Whether any process of a group still runs, two seconds on."""
    for _ in range(20):
        try:
            os.killpg(group, 0)
        except ProcessLookupError:
            return False
        time.sleep(0.1)
    return True
