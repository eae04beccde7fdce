"""Executables kept on disk beside JAX's own cache, which spares the next run tracing as well as compiling.

JAX's cache is asked with a lowered program, and tracing and lowering a robot's step takes longer than reading its
executable. What is kept here is asked with what the program was made from.

An executable that JAX's cache has loaded cannot be kept: XLA leaves functions out of it when it is written again
("Function wrapped_broadcast not found", jaxlib 0.9). So a program bears its key in its name, which JAX's cache heeds.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import logging
import os
import pickle
import tempfile
import threading
from collections.abc import Callable, Iterable
from functools import cache
from pathlib import Path
from typing import Any

import jax
import numpy as np
from jax.experimental import serialize_executable

from estexp_jax.lanes.processor import processor_name

_FOLDER = "steps"
_MOST = 96
"""Executables that are kept, each of some 3 MB; those unused for longest go."""
_PACKAGES = ("jax", "jaxlib", "mujoco", "mujoco-mjx", "numpy")

_CALLS_OUT = "custom-call"
"""In the text of a program that calls LAPACK, which is only ready once JAX has lowered such a call in this process."""

log = logging.getLogger(__name__)


_CACHE_HIT = "/jax/compilation_cache/cache_hits"
_loaded = threading.local()


def stored(identity: Iterable[bytes], arguments: Any, compile_it: Callable[[str], Any]) -> Any:
    """An executable from the disk, or compiled and then kept there; only compiled where JAX keeps no programs.

    Args:
        identity: all that the program was made from beside its arguments' shapes, this package's own source and the
            versions of those it is built on.
        arguments: what it will be called with.
        compile_it: compiles it, under a name that ends so.
    """
    folder = _folder()
    if folder is None:
        return compile_it("")
    key = _key(identity, arguments)
    path = folder / f"{key}.program"
    found = _read(path)
    if found is None:
        _listen()
        _loaded.any = False
        found = compile_it(key)
        if not _loaded.any:
            _write(path, found)
    return found


@cache
def _listen() -> None:
    """Learn, thread by thread, when JAX's cache loads an executable."""

    def note(event: str, **_: str | int) -> None:
        if event == _CACHE_HIT:
            _loaded.any = True

    jax.monitoring.register_event_listener(note)


def _folder() -> Path | None:
    """Where executables are kept; None: nowhere."""
    cache_folder = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue] (made at run time)
    if not cache_folder or "://" in cache_folder or jax.default_backend() != "cpu":
        return None
    return Path(cache_folder) / _FOLDER


def _key(identity: Iterable[bytes], arguments: Any) -> str:
    leaves, tree = jax.tree.flatten(arguments)
    shapes = [(np.shape(x), np.asarray(x).dtype.name) for x in leaves]
    wide = jax.config.jax_enable_x64  # pyright: ignore[reportAttributeAccessIssue] (made at run time)
    here = (_versions(), processor_name(), jax.device_count(), wide, str(tree), shapes)
    found = hashlib.sha256(repr(here).encode())
    for part in (_source(), *identity):
        found.update(hashlib.sha256(part).digest())
    return found.hexdigest()


def _read(path: Path) -> Any | None:
    try:
        parts = pickle.loads(path.read_bytes())  # noqa: S301 (of the user's own cache, as JAX's own files are)
        found = serialize_executable.deserialize_and_load(*parts)
        os.utime(path)
    except FileNotFoundError:
        return None
    except Exception as error:  # noqa: BLE001 (whatever is wrong with a kept file, the program is compiled)
        log.debug("%s is of no use: %s", path, error)
        return None
    return found


def _write(path: Path, program: Any) -> None:
    """Keep an executable, if it can be; whole or not at all."""
    try:
        if _CALLS_OUT in program.as_text():
            return
        content = pickle.dumps(serialize_executable.serialize(program))
        path.parent.mkdir(exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, delete=False) as file:
            file.write(content)
        Path(file.name).replace(path)
        kept = sorted(path.parent.glob("*.program"), key=lambda p: p.stat().st_mtime)
        for old in kept[:-_MOST]:
            old.unlink(missing_ok=True)
    except Exception as error:  # noqa: BLE001 (it only costs time)
        log.debug("%s is not kept: %s", path, error)


@cache
def _versions() -> tuple[str, ...]:
    return tuple(f"{name} {importlib.metadata.version(name)}" for name in _PACKAGES)


@cache
def _source() -> bytes:
    """A digest of this package's source: what is changed in it changes programs."""
    root = Path(__file__).parents[1]
    found = hashlib.sha256()
    for path in sorted(p for room in ("lanes", "physics") for p in (root / room).rglob("*.py")):
        found.update(path.relative_to(root).as_posix().encode())
        found.update(path.read_bytes())
    return found.digest()
