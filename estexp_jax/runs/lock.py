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
except ImportError:  # Windows: a second process is not detected
    fcntl = None

LOCK = ".estexp-run.lock"
"""The lock file. It is never removed, since removal would let a third process in beside a second one."""

_EVERY = 0.2
"""Time between two attempts to lock a folder, s."""
_NO_LOCKS = (errno.ENOLCK, errno.ENOTSUP, errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL)
"""Errors of file systems without locks; such folders are used without a lock."""


@final
class FolderLock:
    """The lock of a folder; held until this object is deleted or the process ends."""

    def __init__(self, handle: int) -> None:
        self._handle = handle
        weakref.finalize(self, os.close, handle)

    def __enter__(self) -> FolderLock:
        return self

    def __exit__(self, *_: object) -> None:
        """Held at least to the end of the block, and longer if the object is referenced elsewhere."""

    def is_of(self, path: Path) -> bool:
        """Whether the lock file at `path` is still the one that is held; the folder may have been removed."""
        try:
            return os.path.samestat(os.fstat(self._handle), path.stat())
        except OSError:
            return False


_HELD: weakref.WeakValueDictionary[Path, FolderLock] = weakref.WeakValueDictionary()
"""Locks of this process, since it may ask twice, and system locks belong to open files, not to processes."""


def lock_folder(folder: Path, patience: float = 0.0) -> FolderLock:
    """Keep other processes out of a folder, on this machine and on those that share it.

    The system releases the lock when the process ends, so a killed run needs no clean-up.

    Args:
        folder: must exist.
        patience: how long to wait for a process that holds it, s.

    Raises:
        InputError: another process holds it, or the lock file cannot be written.
    """
    path = folder.resolve() / LOCK
    own = _HELD.get(path)
    if own is not None and own.is_of(path):
        return own
    end = time.monotonic() + patience
    while (lock := _try_lock(path)) is None:
        if time.monotonic() >= end:
            right = "wait for it to end, or give another folder"
            raise InputError(f"is in use by {_read_owner(path)}", where=str(folder), right=right)
        time.sleep(_EVERY)
    _HELD[path] = lock
    return lock


def _try_lock(path: Path) -> FolderLock | None:
    """The lock; None if another process holds it."""
    try:
        handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
    except OSError as error:
        raise unwritable(path.parent, error) from None
    lock = FolderLock(handle)
    try:
        if fcntl is not None:
            fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return None
    except OSError as error:
        if error.errno not in _NO_LOCKS:
            raise unwritable(path.parent, error) from None
    if not lock.is_of(path):
        return None  # the folder was removed meanwhile
    _write_owner(handle)
    return lock


def _write_owner(handle: int) -> None:
    """Write the owner into the lock file, for messages of other processes; skipped on a full disk."""
    try:
        os.truncate(handle, 0)
        os.pwrite(handle, f"process {os.getpid()} on {socket.gethostname()}".encode(), 0)
    except OSError:
        pass


def _read_owner(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")[:200] or "another process"
    except (OSError, ValueError):
        return "another process"
