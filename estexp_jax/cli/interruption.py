"""Interruptions: Ctrl-C, SIGTERM and SIGHUP end a command with exit code 3, wherever it is, within seconds.

A signal raises KeyboardInterrupt, which ends the work where it is. Two things would keep it from that. While a module
of compiled code is loaded, an exception may be lost or end the process in ways of its own, so that the process ends at
once there. And where the exception is swallowed, or does not come through for long, a timer ends the process. Nothing
is lost by either: whatever a run needs to go on is on disk at any moment.
"""

from __future__ import annotations

import os
import signal
import sys
from threading import Timer
from types import FrameType, TracebackType
from typing import final

INTERRUPTED = 3
"""The exit code."""
MESSAGE = "\nestexp: interrupted; the same command with --resume goes on"
_SIGNALS = ("SIGINT", "SIGTERM", "SIGHUP")
_PATIENCE = 8.0
"""Seconds that ending may take by itself."""
_IMPORTING = "<frozen importlib._bootstrap>"


@final
class Interruptible:
    """A context in which signals interrupt; to be entered in the main thread.

    Attributes:
        received: whether one has come.
    """

    def __init__(self) -> None:
        """Outside of it signals do what they did."""
        self.received = False
        self._before: dict[int, object] = {}
        self._timer: Timer | None = None

    def __enter__(self) -> Interruptible:
        for name in _SIGNALS:
            number = getattr(signal, name, None)
            if number is None or signal.getsignal(number) is signal.SIG_IGN:  # as under nohup
                continue
            try:
                self._before[number] = signal.signal(number, self._on_signal)
            except ValueError:  # not the main thread, where signals are somebody else's
                return self
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)  # type: ignore[arg-type]
        if self._timer is not None:
            self._timer.cancel()

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        if self.received or _imports(frame):
            end_now()
        self.received = True
        self._timer = Timer(_PATIENCE, end_now)
        self._timer.daemon = True
        self._timer.start()
        raise KeyboardInterrupt


def end_now() -> None:
    """End the process with the exit code of an interruption, without the interpreter's own way of ending."""
    try:
        print(MESSAGE, file=sys.stderr, flush=True)
        sys.stdout.flush()
    finally:
        os._exit(INTERRUPTED)


def _imports(frame: FrameType | None) -> bool:
    """Whether a module is being loaded."""
    while frame is not None:
        if frame.f_code.co_filename == _IMPORTING:
            return True
        frame = frame.f_back
    return False
