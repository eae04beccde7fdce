"""Explain every case of a set, each in a process of its own that sees nothing but its recordings.

A case is done when `out/explained/<id>.json` says how its process ended; that file is written last, so a killed run
goes on where it was. A case under way at the kill is resumed from its own checkpoint, as is one that was terminated.
"""

from __future__ import annotations

import ctypes
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from threading import Event, Lock
from typing import Any

from experiments.harness.study import ROOT

_PR_SET_PDEATHSIG = 1
EXPLAIN = (sys.executable, "-m", "estexp_jax.cli.main", "explain")
"""What explains a case, as users would."""
_STOPPED = (-signal.SIGTERM, 3)
"""How a process ends that was terminated or interrupted."""
TIMEOUT = 1800.0
"""A case that takes longer (s) counts as failed."""


class Runner:
    """Runs the cases of a set."""

    def __init__(
        self,
        out: Path,
        workers: int | None,
        timeout: float = TIMEOUT,
        command: tuple[str, ...] = (),
        ray: str | None = None,
        only: Sequence[str] | None = None,
    ) -> None:
        """Of the set in a folder, or some cases of it.

        Args:
            out: the folder.
            workers: cases at a time.
            timeout: most seconds a case.
            command: what replaces `estexp explain`, for tests.
            ray: a cluster's address.
            only: names of the cases; None: all that the folder holds.
        """
        self.out, self.workers, self.timeout, self.ray = out, workers, timeout, ray
        self.command = command or EXPLAIN
        self.only = only
        self.children: set[subprocess.Popen[bytes]] = set()
        self.lock, self.stopped = Lock(), Event()
        self.dies_with_worker = False

    def run(self) -> int:
        """Explain what is not yet explained; gives the number of cases that are still open."""
        held = (p.name for p in (self.out / "cases").iterdir())
        cases = sorted(c for c in held if self.only is None or c in self.only)
        todo = [c for c in cases if not (self.out / "explained" / f"{c}.json").is_file()]
        (self.out / "explained").mkdir(exist_ok=True)
        if self.ray is None:
            self._run_here(todo)
        else:
            self._run_on_ray(todo)
        return sum(not (self.out / "explained" / f"{c}.json").is_file() for c in cases)

    def _run_on_ray(self, todo: list[str]) -> None:
        from estexp_jax.runs.fleet import run_all
        from estexp_jax.runs.workers import worker_pool_of

        calls = [(explain_case, (self.out.resolve(), case, self.timeout, self.command)) for case in todo]
        with worker_pool_of(self.workers, self.ray, [str(ROOT)]) as crew:
            run_all("cases", calls, crew, self.out / "under_way")

    def _run_here(self, todo: list[str]) -> None:
        begin = time.monotonic()
        previous = signal.signal(signal.SIGTERM, self._stop)
        try:
            with ThreadPoolExecutor(self.workers or 1) as pool:
                for i, case in enumerate(pool.map(self._explain, todo)):
                    if self.stopped.is_set():
                        break
                    spent = time.monotonic() - begin
                    left = spent / (i + 1) * (len(todo) - i - 1)
                    print(f"{case}: {i + 1} of {len(todo)}, {spent:.0f} s, about {left:.0f} s left", flush=True)
        except KeyboardInterrupt:
            self._stop()
        finally:
            signal.signal(signal.SIGTERM, previous)

    def _stop(self, *_: Any) -> None:
        """End all children; cases not yet begun stay open."""
        self.stopped.set()
        with self.lock:
            for child in self.children:
                os.killpg(child.pid, signal.SIGTERM)

    def _explain(self, case: str) -> str:
        if self.stopped.is_set():
            return case
        result, begin = self.out / "explained" / case, time.monotonic()
        again = ("--resume",) if result.is_dir() else ()
        code = self._process(case, again)
        if code == 2 and again:  # nothing to resume from
            code = self._process(case, ("--force",))
        if not self.stopped.is_set() and code not in _STOPPED:  # that comes from outside only
            ending = {"code": code, "wall_s": time.monotonic() - begin, "resumed": bool(again)}
            part = result.with_suffix(".part")
            part.write_text(json.dumps(ending), encoding="utf-8")
            part.replace(result.with_suffix(".json"))
        return case

    def _process(self, case: str, flags: tuple[str, ...]) -> int | None:
        """Exit code; None where it took too long."""
        manifest = self.out / "cases" / case / "recordings.toml"
        arguments = [*self.command, str(manifest), "--out", str(self.out / "explained" / case), *flags]
        with (self.out / "explained" / f"{case}.log").open("ab") as log:
            child = subprocess.Popen(
                arguments,
                stdout=log,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                preexec_fn=_die_with_worker if self.dies_with_worker else None,
            )
            with self.lock:
                self.children.add(child)
            try:
                return child.wait(self.timeout)
            except subprocess.TimeoutExpired:
                os.killpg(child.pid, signal.SIGKILL)
                child.wait()
                return None
            finally:
                with self.lock:
                    self.children.discard(child)


def explain_case(out: Path, case: str, timeout: float, command: tuple[str, ...]) -> None:
    """Explain one case in a worker of a cluster; a case that a lost worker had is gone on with."""
    (out / "explained").mkdir(exist_ok=True)
    runner = Runner(out, 1, timeout, command)
    runner.dies_with_worker = sys.platform == "linux"
    runner._explain(case)


def _die_with_worker() -> None:
    """End with the worker, however that ends: what is left would hold the case's folder against the next one."""
    ctypes.CDLL(None).prctl(_PR_SET_PDEATHSIG, signal.SIGKILL)


def findings_of(out: Path, case: str) -> dict[str, Any] | None:
    """What was found in a case; None where nothing came of it."""
    path = out / "explained" / case / "findings.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None


def ending_of(out: Path, case: str) -> dict[str, Any] | None:
    """How a case's process ended; None where it is still open."""
    path = out / "explained" / f"{case}.json"
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else None
