"""Errors that are the user's to mend, and how they are told."""

import errno
from collections.abc import Iterable
from pathlib import Path


class InputError(Exception):
    """Something the user gave is wrong: says what, where, and what would be right.

    The command line prints it as one message and leaves with exit code 2; no traceback.

    Args:
        what: what is wrong, a clause without a final full stop.
        where: file, row, column or name, as the user knows them.
        right: what would be right, or what exists instead.
    """

    def __init__(self, what: str, *, where: str = "", right: str = "") -> None:
        self.what, self.where, self.right = (printable(text) for text in (what, where, right))
        message = f"{self.where}: {self.what}" if where else self.what
        super().__init__(f"{message}; {self.right}" if right else message)


def printable(text: str) -> str:
    """A text from somebody's file on one line, its control characters written out: a terminal would obey them."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else c.encode("unicode_escape").decode() for c in text)


MOST_LISTED = 200
"""Names that a message lists; a broken or hostile file may have any number of them."""


def known(names: Iterable[str]) -> str:
    """The tail of a message about an unknown name: what exists instead."""
    listed = listing(names)
    return f"known are: {listed}" if listed else "there are none"


def listing(names: Iterable[str]) -> str:
    """Names with commas between them, and how many more there are than a message should list."""
    every = list(names)
    more = f" and {len(every) - MOST_LISTED} more" if len(every) > MOST_LISTED else ""
    return printable(", ".join(every[:MOST_LISTED])) + more


def abbreviated(value: object) -> str:
    """A value as a message shows it: its beginning, since the user's file may hold one of any size."""
    try:
        text = repr(value)
    except (ValueError, RecursionError):  # Python writes no whole number of more than some thousand digits
        text = f"a huge {type(value).__name__}"
    return text if len(text) <= 80 else f"{text[:77]}..."


def name_too_long(error: OSError) -> InputError | None:
    """The message about a path with a name that no file system takes; None for any other error."""
    if error.errno != errno.ENAMETOOLONG:
        return None
    return InputError("is too long for the name of a file", where=abbreviated(error.filename), right="a shorter path")


_FULL = (errno.ENOSPC, errno.EDQUOT, errno.EFBIG)


def unwritable(path: Path, error: OSError) -> InputError:
    """The message about a file or folder that the system would not write."""
    if error.errno in _FULL:
        right = "make room, then the same command with --resume goes on"
    else:
        right = "a folder that you may write in"
    return InputError(f"cannot be written: {error.strerror or error}", where=str(path), right=right)
