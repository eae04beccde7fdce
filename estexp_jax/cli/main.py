"""The program `estexp`, from its first instruction to its last: a signal interrupts it, its end is an exit code.

What parses arguments is imported when signals are heard already.
"""

from __future__ import annotations

import os
import signal
import sys

from estexp_jax.cli.interruption import INTERRUPTED, SIGNALS, Interruptible

TYPE_CHECKING = False

if TYPE_CHECKING:
    from collections.abc import Sequence


def main(argv: Sequence[str] | None = None) -> int:
    """Run one command.

    Args:
        argv: the arguments after `estexp`; None: those of this process.

    Returns:
        The exit code: 0 done, 2 the input is wrong, 3 interrupted. A defect of ours is an exception, so 1.
    """
    with Interruptible() as interruptible:
        return _ended(sys.argv[1:] if argv is None else argv, interruptible)


def program() -> None:
    """The program `estexp`: the command of this process, and its end."""
    interruptible = Interruptible()
    interruptible.begin()
    code = _ended(sys.argv[1:], interruptible, is_last=True)
    if code == INTERRUPTED:  # threads of others may be in the middle of something, and fail when the interpreter ends
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code)
    sys.exit(code)


def _ended(argv: Sequence[str], interruptible: Interruptible, *, is_last: bool = False) -> int:
    """Run a command; its exit code, whatever became of an interruption on its way."""
    try:
        from estexp_jax.cli.commands import run_command

        code = run_command(argv)
        if is_last:  # the work is done; while the interpreter ends, no signal can be handled any more
            _ignore_signals()
        return code
    except BaseException as error:
        if not (interruptible.received or isinstance(error, KeyboardInterrupt)):
            raise
        interruptible.tell()
        return INTERRUPTED


def _ignore_signals() -> None:
    for number in SIGNALS:
        signal.signal(number, signal.SIG_IGN)


if __name__ == "__main__":
    program()
