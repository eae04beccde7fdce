"""Many runs in one view: each tells how far it is in a small file, on the folder that all machines share."""

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
"""Least time between two words of a run, and between two looks at all, s."""
_STALE = 120.0
"""A run that has said nothing for so long is not shown: its worker may be lost, s."""
_SHOWN = 2
"""Runs that the view names."""


@final
class Heartbeat:
    """A run under way tells how far it is; nobody sees it any more when the context ends.

    Args:
        folder: of all runs' words; made if need be.
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

    def tell(self, share: float, where: str) -> None:
        """How far it is: a share of the whole (0 to 1), and what is under way. A full disk only silences it."""
        if time.monotonic() - self._last >= _EVERY:
            with suppress(InputError):
                write_json(self._path, {"share": share, "where": where, "machine": socket.gethostname()})
            self._last = time.monotonic()


def under_way(folder: Path) -> dict[str, dict[str, Any]]:
    """What the runs under way last said, by their names."""
    said = {}
    for path in sorted(folder.glob("*.json")):
        with suppress(OSError, ValueError):  # it may end while we look
            if time.time() - path.stat().st_mtime < _STALE:
                said[path.stem] = json.loads(path.read_text(encoding="utf-8"))
    return said


def run_all(
    title: str, calls: Sequence[Call], crew: WorkerPool, beats: Path, progress: ProgressDisplay | None = None
) -> list[Any]:
    """Let a crew do calls, and show how far all of them are.

    Args:
        title: what they are: `runs`.
        calls: functions and arguments.
        crew: who does them.
        beats: the folder of the runs' words.
        progress: where it shows; None: on the terminal.

    Returns:
        What they gave, in the order of the calls.
    """
    results: list[Any] = [None] * len(calls)
    if not calls:
        return results
    begin = time.monotonic()
    with ProgressDisplay() if progress is None else progress as shown:
        shown.say(f"{title}: {len(calls)} to do, {crew.about()}")
        shown.stage(title, total=len(calls))
        view = _View(shown, crew, beats, len(calls))
        with view.watching():
            for index, result in crew.each(calls):
                results[index] = result
                view.count += 1
                view.show()
        shown.say(f"{title}: {len(calls)} done in {duration(time.monotonic() - begin)}")
    return results


@final
class _View:
    """How many calls are done, and how far the others are."""

    def __init__(self, progress: ProgressDisplay, crew: WorkerPool, beats: Path, total: int) -> None:
        self._progress, self._crew, self._beats, self._total = progress, crew, beats, total
        self._about, self.count = crew.about(), 0

    def show(self) -> None:
        said = under_way(self._beats)
        done = min(self.count + sum(each["share"] for each in said.values()), self._total)
        self._progress.reach(round(done, 1) if self.count < self._total else self._total, self._note(said))

    @contextmanager
    def watching(self) -> Iterator[None]:
        """Look now and then, in a thread of its own: a crew tells only of what is done."""
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
            with suppress(Exception):  # a cluster that does not answer now is asked again
                self._tell_of_crew()
            self.show()

    def _tell_of_crew(self) -> None:
        """Machines that were lost, or have come."""
        about = self._crew.about()
        if about != self._about:
            self._progress.say(f"now {about}; before, {self._about}")
            self._about = about

    def _note(self, said: dict[str, dict[str, Any]]) -> str:
        named = [f"{name} on {each['machine']}: {each['where']}" for name, each in list(said.items())[:_SHOWN]]
        more = f"; {len(said) - _SHOWN} more" if len(said) > _SHOWN else ""
        return f"{len(said)} under way ({'; '.join(named)}{more})" if said else ""
