"""Progress of many runs in one view: each reports its progress in a small file in a shared folder."""

from __future__ import annotations

import json
import socket
import threading
import time
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any, final

from estexp_jax.errors import InputError
from estexp_jax.runs.files import drafts_of, write_json
from estexp_jax.runs.progress import ProgressDisplay, duration
from estexp_jax.runs.workers import Call, WorkerPool

_EVERY = 2.0
"""Shortest time between two reports of a run, and between two updates of the view, s."""
_STALE = 120.0
"""Age of a report, s, above which it is ignored, since the run's worker may be lost."""
_N_NAMED = 2
"""How many runs the view names."""


@final
class Heartbeat:
    """Reports of a run under way; they are removed when the context ends.

    Args:
        folder: of the reports of all runs; created if needed.
        name: of the run.
    """

    def __init__(self, folder: Path, name: str) -> None:
        self._path, self._last = folder / f"{name}.json", -_EVERY

    def __enter__(self) -> Heartbeat:
        with suppress(OSError):
            self._path.parent.mkdir(parents=True, exist_ok=True)
            for draft in drafts_of(self._path):  # by a worker that was killed
                draft.unlink(missing_ok=True)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        with suppress(OSError):
            self._path.unlink(missing_ok=True)

    def report(self, share: float, where: str) -> None:
        """Report progress. A full disk is ignored.

        Args:
            share: of the whole, 0 to 1.
            where: the stage that is under way.
        """
        if time.monotonic() - self._last >= _EVERY:
            with suppress(InputError):
                write_json(self._path, {"share": share, "where": where, "machine": socket.gethostname()})
            self._last = time.monotonic()


def under_way(folder: Path) -> dict[str, dict[str, Any]]:
    """The last reports of the runs under way, by name."""
    reports = {}
    for path in sorted(folder.glob("*.json")):
        with suppress(OSError, ValueError):  # the run may end meanwhile
            if time.time() - path.stat().st_mtime < _STALE:
                reports[path.stem] = json.loads(path.read_text(encoding="utf-8"))
    return reports


def run_all(
    title: str, calls: Sequence[Call], pool: WorkerPool, folder: Path, progress: ProgressDisplay | None = None
) -> list[Any]:
    """Run calls on a pool of workers, and show the progress of all of them.

    Args:
        title: of the calls, such as `runs`.
        calls: functions and arguments.
        pool: the workers.
        folder: of the runs' reports (see `Heartbeat`).
        progress: the display; None: a new one on the terminal.

    Returns:
        The results, in order of the calls.
    """
    results: list[Any] = [None] * len(calls)
    if not calls:
        return results
    begin = time.monotonic()
    with ProgressDisplay() if progress is None else progress as display:
        display.say(f"{title}: {len(calls)} to do, {pool.summary()}")
        display.stage(title, total=len(calls))
        view = _FleetView(display, pool, folder, len(calls))
        with view.watching():
            for index, result in pool.each(calls):
                results[index] = result
                view.count += 1
                view.show()
        display.say(f"{title}: {len(calls)} done in {duration(time.monotonic() - begin)}")
    return results


@final
class _FleetView:
    """The number of finished calls, and the progress of the others."""

    def __init__(self, progress: ProgressDisplay, pool: WorkerPool, folder: Path, total: int) -> None:
        self._progress, self._pool, self._folder, self._total = progress, pool, folder, total
        self._summary, self.count = pool.summary(), 0

    def show(self) -> None:
        reports = under_way(self._folder)
        done = min(self.count + sum(report["share"] for report in reports.values()), self._total)
        self._progress.reach(round(done, 1) if self.count < self._total else self._total, self._note(reports))

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Update the view regularly in a thread, since a pool reports finished calls only."""
        ended = threading.Event()
        watcher = threading.Thread(target=self._watch, args=(ended,), name="fleet", daemon=True)
        watcher.start()
        try:
            yield
        finally:
            ended.set()
            watcher.join()

    def _watch(self, ended: threading.Event) -> None:
        while not ended.wait(_EVERY):
            with suppress(Exception):  # a cluster that does not answer is asked again later
                self._report_pool()
            self.show()

    def _report_pool(self) -> None:
        """Report machines that were lost or added."""
        summary = self._pool.summary()
        if summary != self._summary:
            self._progress.say(f"now {summary}; before, {self._summary}")
            self._summary = summary

    def _note(self, reports: dict[str, dict[str, Any]]) -> str:
        first = list(reports.items())[:_N_NAMED]
        named = [f"{name} on {report['machine']}: {report['where']}" for name, report in first]
        more = f"; {len(reports) - _N_NAMED} more" if len(reports) > _N_NAMED else ""
        return f"{len(reports)} under way ({'; '.join(named)}{more})" if reports else ""
