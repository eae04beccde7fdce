"""Progress of a run: a live line on a terminal, periodic plain lines elsewhere, and messages."""

from __future__ import annotations

import sys
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from types import TracebackType
from typing import Any, TextIO, final

PERIOD = 10.0
"""Time between two plain lines, s."""


@dataclass
class _Stage:
    """The running stage; `total` is None if its length is unknown."""

    name: str
    total: float | None
    began: float
    done: float = 0.0
    note: str = ""

    def line(self, now: float) -> str:
        """`exploration 1/5: 12/40, 30 s, about 1 min 10 s left, best 3.2 m`."""
        parts = []
        if self.total is not None:
            parts.append(f"{self.done:g}/{self.total:g}")
        elif self.done:
            parts.append(f"{self.done:g}")
        parts.append(duration(now - self.began))
        if self.total is not None and 0 < self.done < self.total:
            parts.append(f"about {duration((now - self.began) / self.done * (self.total - self.done))} left")
        return f"{self.name}: {', '.join([*parts, self.note] if self.note else parts)}"


def duration(seconds: float) -> str:
    """A duration in words: `45 s`, `1 min 10 s`, `2 h 5 min`."""
    whole = round(seconds)
    if whole < 60:
        return f"{whole} s"
    if whole < 3600:
        return f"{whole // 60} min {whole % 60} s"
    return f"{whole // 3600} h {whole % 3600 // 60} min"


@final
@dataclass
class ProgressDisplay:
    """Shows the running stage, its progress and an estimate of the remaining time.

    On a terminal this is one live line. Elsewhere it is a plain line on standard error, at once and then every
    `PERIOD`, so that a log shows activity even while compiling. Messages of `say` always go to standard output.

    ```python
    with ProgressDisplay() as progress:
        progress.stage("exploration 1/5", total=40)
        progress.advance(note="best 3.2 m")
        progress.say("walks 3.2 m")
    ```

    Attributes:
        out: stream of messages; None: `sys.stdout`.
        err: stream of plain progress lines; None: `sys.stderr`.
        period: time between two plain lines, s.
        clock: monotonic time, s.
    """

    out: TextIO | None = None
    err: TextIO | None = None
    period: float = PERIOD
    clock: Callable[[], float] = time.monotonic
    _stage: _Stage | None = field(default=None, init=False, repr=False)
    _last: float | None = field(default=None, init=False, repr=False)
    _live: _Live | None = field(default=None, init=False, repr=False)
    _ends: threading.Event = field(default_factory=threading.Event, init=False, repr=False)
    _lock: Any = field(default_factory=threading.RLock, init=False, repr=False)

    def __enter__(self) -> ProgressDisplay:
        out, err = self.out or sys.stdout, self.err or sys.stderr
        self.out, self.err = out, err
        terminal = next((stream for stream in (out, err) if stream.isatty()), None)
        if terminal is not None:
            self._live = _Live(terminal)
        else:
            threading.Thread(target=self._tick_on, name="progress", daemon=True).start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._ends.set()
        if self._live is not None:
            self._live.close()
        self._live = self._stage = None

    def say(self, text: str) -> None:
        """Print a message."""
        if self._live is not None and self._live.stream is self.out:
            self._live.print(text)
        else:
            print(text, file=self.out or sys.stdout, flush=True)

    def stage(self, name: str, total: float | None = None) -> None:
        """Start the next stage.

        Args:
            name: such as `exploration 1/5`.
            total: number of steps of `advance`; None: unknown.
        """
        with self._lock:
            self._stage = _Stage(name, total, self.clock())
            if self._live is not None:
                self._live.stage(name, total)
            self.tick()

    def advance(self, steps: float = 1, note: str = "") -> None:
        """Advance the stage by some steps.

        Args:
            steps: number of steps.
            note: remark, such as the best result so far; if empty, the last one stays.
        """
        with self._lock:
            if self._stage is None:
                raise RuntimeError("no stage to advance")
            self._stage.done += steps
            self._stage.note = note or self._stage.note
            if self._live is not None:
                self._live.advance(steps, self._stage.note)
            self.tick()

    def reach(self, done: float, note: str = "") -> None:
        """Set the progress of the stage.

        Args:
            done: steps from its start; may be less than before, if work was lost.
            note: as for `advance`.
        """
        with self._lock:
            self.advance(done - (self._stage.done if self._stage is not None else 0.0), note)

    def tick(self) -> None:
        """Print a plain line if one is due."""
        with self._lock:
            now = self.clock()
            due = self._last is None or now - self._last >= self.period
            if self._live is None and self._stage is not None and due and not self._ends.is_set():
                print(self._stage.line(now), file=self.err or sys.stderr, flush=True)
                self._last = now

    def _tick_on(self) -> None:
        while not self._ends.wait(self.period / 10.0):
            self.tick()


@final
class _Live:
    """The live line on a terminal."""

    def __init__(self, stream: TextIO) -> None:
        from rich import progress as parts
        from rich.console import Console

        self.stream = stream
        name, note = (parts.TextColumn(text, markup=False) for text in ("{task.description}", "{task.fields[note]}"))
        counters = (parts.MofNCompleteColumn(), parts.TimeElapsedColumn(), parts.TimeRemainingColumn())
        columns = (parts.SpinnerColumn(), name, parts.BarColumn(), *counters, note)
        # Only messages of `say` go above the line: redirection would move all of standard output to this stream.
        self._bars = parts.Progress(
            *columns, console=Console(file=stream), transient=True, redirect_stdout=False, redirect_stderr=False
        )
        self._task: Any = None
        self._bars.start()

    def print(self, text: str) -> None:
        self._bars.console.print(text, markup=False, highlight=False, soft_wrap=True)

    def stage(self, name: str, total: float | None) -> None:
        if self._task is not None:
            self._bars.remove_task(self._task)
        self._task = self._bars.add_task(name, total=total, note="")

    def advance(self, steps: float, note: str) -> None:
        self._bars.update(self._task, advance=steps, note=note)

    def close(self) -> None:
        self._bars.stop()
