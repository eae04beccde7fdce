"""One process at a time in a folder."""

from __future__ import annotations

import errno
import os
import socket
import time
import weakref
from pathlib import Path
from typing import final

from estexp_jax.errors import InputError, unwritable

try:
    import fcntl
except ImportError:  # Windows: the second process is not noticed
    fcntl = None

LOCK = ".estexp-run.lock"
"""The file that is locked. It stays when nobody holds it: removing it would let a third process in beside a second."""

_EVERY = 0.2
"""Time between two looks at a folder that another process holds, s."""
_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
"""What a file system that knows no locks answers; such a folder is used without."""


@final
class FolderLock:
    """A folder that this process holds; until this object is gone, or the process, however it ended."""

    def __init__(self, handle: int) -> None:
        self._handle = handle
        weakref.finalize(self, os.close, handle)

    def __enter__(self) -> FolderLock:
        return self

    def __exit__(self, *_: object) -> None:
        """Held to the end of the block at least; longer where somebody else in this process keeps the object."""

    def is_of(self, path: Path) -> bool:
        """Whether the lock file at `path` is the one that is held: somebody may have removed the folder since."""
        try:
            return os.path.samestat(os.fstat(self._handle), path.stat())
        except OSError:
            return False


_HELD: weakref.WeakValueDictionary[Path, FolderLock] = weakref.WeakValueDictionary()
"""What this process holds. The system's locks tell open files apart, not processes, and a process may ask twice."""


def lock_folder(folder: Path, patience: float = 0.0) -> FolderLock:
    """Keep other processes out of a folder, on this machine and on those that share it.

    The system releases the lock with the process, so that a run that is killed leaves nothing to clear away.

    Args:
        folder: it must exist.
        patience: how long to wait for a process that holds it, s.

    Raises:
        InputError: another process holds it, or the lock file cannot be written.
    """
    path = folder.resolve() / LOCK
    mine = _HELD.get(path)
    if mine is not None and mine.is_of(path):
        return mine
    end = time.monotonic() + patience
    while (found := _taken(path)) is None:
        if time.monotonic() >= end:
            right = "wait for it to end, or give another folder"
            raise InputError(f"is in use by {_holder(path)}", where=str(folder), right=right)
        time.sleep(_EVERY)
    _HELD[path] = found
    return found


def _taken(path: Path) -> FolderLock | None:
    """The lock; None where another process has it."""
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise unwritable(path.parent, error) from None
    found = FolderLock(handle)
    try:
        if fcntl is not None:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return None
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise unwritable(path.parent, error) from None
    if not found.is_of(path):
        return None  # the folder was removed meanwhile
    _sign(handle)
    return found


def _sign(handle: int) -> None:
    """Say who holds it, for the message to others; on a full disk nobody is told."""
    try:
        os.truncate(handle, 0)
        os.pwrite(handle, f"process {os.getpid()} on {socket.gethostname()}".encode(), 0)
    except OSError:
        pass


def _holder(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")[:200] or "another process"
    except (OSError, ValueError):
        return "another process"
