"""Interruptions: Ctrl-C, SIGTERM and SIGHUP end a command with exit code 3, wherever it is, within seconds.

A signal raises KeyboardInterrupt, which ends the work where it is. Three things would keep it from that. While a module
of compiled code is loaded, an exception may be lost or end the process in ways of its own, so that the process ends at
once there; so it does in a destructor, which would swallow it. While compiled code runs, Python's handlers wait; so a
thread hears of signals as well, by the descriptor that the interpreter itself writes to. And where the exception is
swallowed, or does not come through for long, that thread ends the process. Nothing is lost by any of it: whatever a run
needs to go on is on disk at any moment.
"""

from __future__ import annotations

import os
import signal
import sys

TYPE_CHECKING = False  # until signals are handled, nothing is imported that can wait

if TYPE_CHECKING:
    from threading import Timer
    from types import FrameType, TracebackType
    from typing import Any

INTERRUPTED = 3
"""The exit code."""
MESSAGE = "\nestexp: interrupted; the same command with --resume goes on\n"
SIGNALS = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Those that interrupt; Windows has no SIGHUP."""
_PATIENCE_S = 5.0
"""Time that ending may take by itself."""
_FLUSH_S = 0.5
"""Time to write out what was printed: whoever should read it may be gone."""
_IMPORTING = "<frozen importlib._bootstrap>"
_SHOW_CURSOR = "\x1b[?25h"
"""What a terminal needs where a live line had hidden its cursor."""


class Interruptible:
    """A context in which signals interrupt; to be entered in the main thread.

    Attributes:
        received: whether one has come.
    """

    def __init__(self) -> None:
        """Outside of it signals do what they did."""
        self.received = False
        self._has_reported = False
        self._before: dict[int, object] = {}
        self._descriptors: tuple[int, int, int] | None = None
        self._timer: Timer | None = None
        self._hook = sys.unraisablehook

    def begin(self) -> None:
        """Hear signals; without an `__exit__`, to the end of the process."""
        for number in SIGNALS:
            if signal.getsignal(number) is signal.SIG_IGN:  # as under nohup
                continue
            try:
                self._before[number] = signal.signal(number, self._on_signal)
            except ValueError:  # not the main thread, where signals are somebody else's
                return
        import threading

        reading, writing = os.pipe()
        os.set_blocking(writing, False)
        self._descriptors = reading, writing, signal.set_wakeup_fd(writing, warn_on_full_buffer=False)
        threading.Thread(target=self._watch, args=(reading,), name="signals", daemon=True).start()
        self._hook, sys.unraisablehook = sys.unraisablehook, self._on_unraisable

    def tell(self) -> None:
        """Say once how to go on."""
        if not self._has_reported:
            self._has_reported = True
            sys.stderr.write(MESSAGE)

    def __enter__(self) -> Interruptible:
        self.begin()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        for number, before in self._before.items():
            signal.signal(number, before)  # type: ignore[arg-type]
        if self._descriptors is not None:
            _, writing, before = self._descriptors
            signal.set_wakeup_fd(before)
            os.close(writing)  # which ends the thread
            sys.unraisablehook = self._hook
        if self._timer is not None:
            self._timer.cancel()

    def _on_signal(self, number: int, frame: FrameType | None) -> None:
        if self.received or _imports(frame):
            end_now()
        self.received = True
        raise KeyboardInterrupt

    def _on_unraisable(self, unraisable: Any) -> None:
        if self.received and isinstance(unraisable.exc_value, KeyboardInterrupt):
            end_now()
        self._hook(unraisable)

    def _watch(self, reading: int) -> None:
        """In a thread: end the process some time after the first signal, and at the second."""
        from threading import Timer

        count = 0
        while received_bytes := os.read(reading, 64):
            count += sum(number in self._before for number in received_bytes)
            if count > 1:
                end_now()
            if count and self._timer is None:
                self._timer = Timer(_PATIENCE_S, end_now)
                self._timer.daemon = True
                self._timer.start()
        os.close(reading)


def end_now() -> None:
    """End the process with the exit code of an interruption, without the interpreter's own way of ending."""
    try:
        is_terminal = os.isatty(2)
        os.write(2, ((_SHOW_CURSOR if is_terminal else "") + MESSAGE).encode())
        import threading

        flushing = threading.Thread(target=_flush, daemon=True)
        flushing.start()
        flushing.join(_FLUSH_S)
    finally:
        os._exit(INTERRUPTED)


def _flush() -> None:
    try:
        sys.stdout.flush()
    except (OSError, ValueError, AttributeError):  # nobody reads it, it is closed, or there is none
        pass


def _imports(frame: FrameType | None) -> bool:
    """Whether a module is being loaded."""
    while frame is not None:
        if frame.f_code.co_filename == _IMPORTING:
            return True
        frame = frame.f_back
    return False
