"""One run that is killed at random moments, and gone on with after each, until it ends."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import time
from pathlib import Path
from typing import Any

import numpy as np

from experiments.robustness.crash_recovery.subjects import differences, drafts, line, unreadable

_CLOCK, _LOOK = 0.05, 0.002
"""Time between two looks at the clock, and for drafts, s: a draft of some kilobytes lives for little longer."""
_TICK = os.sysconf("SC_CLK_TCK")


def whole(command: str, inputs: Path, out: Path) -> dict[str, Any]:
    """A run that nobody kills: its exit code, and the processor time that it took, s."""
    shutil.rmtree(out, ignore_errors=True)
    process, begin = _start(command, inputs, out), time.monotonic()
    took = 0.0
    while process.poll() is None:
        took = max(took, spent(process.pid))
        time.sleep(0.05)
    return {"code": process.returncode, "cpu_s": took, "wall_s": time.monotonic() - begin}


def killed(
    command: str, inputs: Path, reference: Path, out: Path, cpu: float, kills: int, random: np.random.Generator
) -> dict[str, Any]:
    """A run that is killed so many times, at moments of its processor time, and then left alone.

    Args:
        command: which.
        inputs: what it reads.
        reference: the results of a run that nobody killed.
        out: its folder; emptied.
        cpu: processor time of a run that nobody killed, s.
        kills: how many.
        random: draws the moments; every second kill waits for the next write to be under way.
    """
    shutil.rmtree(out, ignore_errors=True)
    found = []
    for number in range(kills):
        at, write = float(random.uniform(0.0, cpu)), number % 2 == 1
        left = set(drafts(out))  # by the kill before
        came = _kill_at(_start(command, inputs, out), out, at, write, left)
        found.append({"at_cpu_s": at, "in_a_write": write, "came": came, **_found(out)})
    process = _start(command, inputs, out)
    code = process.wait()
    error = process.stderr.read().decode() if process.stderr is not None else ""
    end = {"code": code, "traceback": "Traceback" in error, "drafts_left": drafts(out)}
    return {"kills": found, **end, "differs": differences(reference, out), "unreadable": unreadable(out)}


def _found(out: Path) -> dict[str, Any]:
    """What a kill left."""
    half = drafts(out)
    return {"drafts": half, "unreadable": unreadable(out) if out.is_dir() else [], "begun": out.is_dir()}


def _start(command: str, inputs: Path, out: Path) -> subprocess.Popen[bytes]:
    """The command, with all its processes in a group of their own."""
    arguments = line(command, inputs, out)
    return subprocess.Popen(
        arguments, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, start_new_session=True, env={**os.environ}
    )


def _kill_at(process: subprocess.Popen[bytes], out: Path, at: float, write: bool, left: set[str]) -> bool:
    """Kill the group at a processor time, or at the first new draft seen after it; False where it ended before."""
    while process.poll() is None and spent(process.pid) < at:
        time.sleep(_CLOCK)
    while process.poll() is None and write and not set(drafts(out)) - left:
        time.sleep(_LOOK)
    came = process.poll() is None
    if came:
        os.killpg(process.pid, signal.SIGKILL)
    process.communicate()
    return came


def spent(process: int) -> float:
    """Processor time of a process and its children so far, s: it goes on however busy the machine is."""
    try:
        fields = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()
        children = Path(f"/proc/{process}/task/{process}/children").read_text().split()
    except OSError:  # it has ended
        return 0.0
    return sum(map(int, fields[11:15])) / _TICK + sum(spent(int(child)) for child in children)
