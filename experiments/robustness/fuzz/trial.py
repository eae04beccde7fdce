"""One bad input given to the program: what came of it."""

from __future__ import annotations

import hashlib
import os
import random
import resource
import shutil
import signal
import sys
import tempfile
import traceback
from collections.abc import Callable, Mapping
from contextlib import ExitStack, contextmanager, nullcontext, suppress
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

from experiments.robustness.fuzz import data_sets, folders, logs, models

Maker = Callable[[random.Random, Path], list[str]]
LONGEST_S = 10
KINDS = ("csv", "npz", "parquet", "lerobot", "mcap", "manifest", "mjcf", "run_folder")


class Outcome(NamedTuple):
    """What came of one input."""

    digest: str  #: of what was written and of the command
    result: str  #: refused, accepted, or defect
    message: str  #: the message, or what is wrong


class Accepted(BaseException):
    """The input was taken, and the long work would begin: the trial ends here."""


class Hang(BaseException):
    """Longer than anybody waits."""


def makers(good: Path) -> Mapping[str, Maker]:
    """What makes an input of each kind; `good` holds the results that run folders are copied from."""
    readers = {name: getattr(logs, name) for name in ("csv", "npz", "parquet", "mcap")}
    rest = {
        "lerobot": data_sets.lerobot,
        "manifest": folders.manifest,
        "mjcf": models.mjcf,
        "run_folder": folders.RunFolders(good),
    }
    return {**readers, **rest}


def attempt(make: Maker, source: random.Random) -> Outcome:
    """Make an input in a folder of its own, and run its command on it in this process."""
    folder = Path(tempfile.mkdtemp(prefix="fuzz-"))
    try:
        inner = folder / "in"
        inner.mkdir()
        (folder / "canary").write_text("alive")
        argv = make(source, inner)
        digest = _digest(inner, argv)
        result, message = judged(*run(argv, inner, short=isinstance(make, folders.RunFolders)))
        if (folder / "canary").read_text() != "alive":
            result, message = "defect", "a file outside was changed"
        return Outcome(digest, result, message.replace(str(folder), ""))
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def warm(make: Maker) -> None:
    """Import and compile what all trials need, without a limit."""
    short = _short() if isinstance(make, folders.RunFolders) else nullcontext()
    with short, tempfile.TemporaryDirectory() as folder, _caught():
        for number in range(12):
            inner = Path(folder) / f"{number}"
            inner.mkdir()
            with suppress(BaseException):
                _command(make(random.Random(number), inner))


def _digest(folder: Path, argv: list[str]) -> str:
    state = hashlib.blake2b(digest_size=8)
    for path in sorted(folder.rglob("*")):
        state.update(path.name.encode("utf-8", "surrogateescape"))
        if path.is_symlink():
            state.update(os.readlink(path).encode("utf-8", "surrogateescape"))
        elif path.is_file():
            state.update(path.read_bytes())
    state.update(" ".join(arg.replace(str(folder), "") for arg in argv).encode())
    return state.hexdigest()


def run(argv: list[str], cwd: Path, *, short: bool) -> tuple[int, str]:
    """Run a command in a folder, in this process.

    Args:
        argv: its arguments.
        cwd: the folder.
        short: whether it ends where the long work would begin.

    Returns:
        Its exit code and its messages; 1 and what was raised for a defect.
    """
    before = os.getcwd()
    os.chdir(cwd)  # MuJoCo's log goes there, and what is relative
    try:
        with _caught() as caught, _short() if short else nullcontext(), _limited():
            try:
                code = _command(argv)
            except Accepted:
                code = 0
            except Hang:
                return 1, f"hang: longer than {LONGEST_S} s"
            except BaseException as error:
                place = traceback.extract_tb(error.__traceback__)[-1]
                return 1, f"{type(error).__name__}: {error} ({place.filename}:{place.lineno})"
    finally:
        os.chdir(before)
    return code, caught()


def _command(argv: list[str]) -> int:
    from estexp_jax.cli.main import main

    if argv[0] != "load_explained":
        return main(argv)
    from estexp_jax.api.simulator import load_explained
    from estexp_jax.errors import InputError

    try:
        load_explained(argv[1])
    except InputError as error:
        print(f"estexp: error: {error}", file=sys.stderr)
        return 2
    return 0


def judged(code: int, message: str) -> tuple[str, str]:
    """Whether an input was refused with one message or accepted, and what was told."""
    lines = message.strip().splitlines()
    if code == 0:
        return "accepted", ""
    if code != 2:
        return "defect", f"exit code {code}: {message[-300:]}"
    if len(lines) != 1 or not lines[0].startswith("estexp: error: "):
        return "defect", f"not one message: {message[-300:]}"
    return "refused", lines[0][:300]


@contextmanager
def _caught() -> Any:
    """Everything that goes to stderr, C's included, and stdout out of the way."""
    with tempfile.TemporaryFile() as stderr, open(os.devnull, "wb") as nowhere, ExitStack() as stack:
        for stream, number, target in ((sys.stdout, 1, nowhere), (sys.stderr, 2, stderr)):
            stream.flush()
            kept = os.dup(number)
            os.dup2(target.fileno(), number)
            stack.callback(os.close, kept)
            stack.callback(os.dup2, kept, number)
        stack.enter_context(patch.object(sys, "stdout", stack.enter_context(open(os.devnull, "w"))))
        copy = stack.enter_context(os.fdopen(os.dup(2), "w", errors="replace"))
        stack.enter_context(patch.object(sys, "stderr", copy))

        def message() -> str:
            return content

        content = ""
        try:
            yield message
        finally:
            sys.stderr.flush()
            stderr.seek(0)
            content = stderr.read().decode("utf-8", "replace")


@contextmanager
def _limited() -> Any:
    """A clock of processor time, as the machine may be busy, that ends what takes too long."""

    def ring(*_: Any) -> None:
        raise Hang

    previous = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, LONGEST_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.signal(signal.SIGPROF, previous)


@contextmanager
def _short() -> Any:
    """Commands that end where their input is read and the long work would begin."""

    def stop(*_: Any, **__: Any) -> Any:
        raise Accepted

    from estexp_jax.recovery import cycle

    with ExitStack() as stack:
        for place in (
            "estexp_jax.api.propose.run_proposal",
            "estexp_jax.api.explain.run_explanation",
            "estexp_jax.recovery.cycle.run_cycle",
            "estexp_jax.api.record.write_recordings",
            "estexp_jax.api.bench.measure",
            "estexp_jax.cli.demo.recover_command",
            "estexp_jax.cli.experiment.subprocess.Popen",
        ):
            stack.enter_context(patch(place, stop))
        stack.enter_context(patch("estexp_jax.recovery.cycle.job_of", _job(cycle.job_of)))
        yield


@lru_cache(maxsize=2)
def _job(job_of: Any) -> Any:
    """The job of `recover`, made once: it costs seconds and does not depend on what is damaged."""
    kept: dict[str, Any] = {}

    def made(robot: Any, settings: Any, *rest: Any) -> Any:
        key = repr(settings)
        if key not in kept:
            kept[key] = job_of(robot, settings, *rest)
        return kept[key]

    return made


def bound_memory(more: int) -> None:
    """So much more address space than now, bytes: what asks for more fails instead of taking the machine down."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    most = pages * resource.getpagesize() + more
    resource.setrlimit(resource.RLIMIT_AS, (most, most))


def peak_mb() -> float:
    """The most memory that this process ever had, MB."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
