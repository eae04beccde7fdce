"""Compiled programs kept from run to run, and how many were compiled."""

from __future__ import annotations

import gc
import hashlib
import os
import platform
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

_COMPILED = "/jax/core/compile/backend_compile_duration"
_FROM_CACHE = "/jax/compilation_cache/cache_hits"
_MOST_MAPS = 0.5
"""Share of the memory maps that a process may have from which on compiled programs are forgotten."""


def enable_compilation_cache() -> Path | None:
    """Keep programs that took long to compile on disk, so that the next run loads them.

    They go to `estexp_jax/xla` in the user's cache folder (`XDG_CACHE_HOME`, else `~/.cache`), in a folder for this
    kind of processor: JAX's own key does not tell processors apart, and in a home that several machines share one would
    run what was compiled for another. A cache that is already configured, or `JAX_COMPILATION_CACHE_DIR` (empty: none),
    is left as it is. A folder that cannot be written costs time only, so it is told in one line. For front doors to
    call; never on import.

    Returns:
        The folder in force; None where there is none.
    """
    import jax

    configured = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue] (made at run time)
    if configured or "JAX_COMPILATION_CACHE_DIR" in os.environ:
        return Path(configured) if configured else None
    try:
        folder = _user_cache() / "estexp_jax" / "xla" / _processor()
        folder.mkdir(parents=True, exist_ok=True)
        if not os.access(folder, os.W_OK | os.X_OK):
            raise PermissionError(f"{folder} may not be written")
    except (OSError, RuntimeError) as error:  # RuntimeError: there is no home
        print(f"estexp: warning: compiled programs are not kept for the next run: {error}", file=sys.stderr)
        return None
    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.5)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    return folder


def forget_programs() -> bool:
    """Forget what was compiled, where the system would soon refuse this process more of it.

    JAX keeps each program for as long as the process lives, each takes some memory maps, and Linux allows a process
    only so many (65530): beyond, it crashes. Who explains hundreds of recordings in one process comes there. What is
    still needed is compiled again, or read from the cache on disk.

    Returns:
        Whether it was done.
    """
    maps = _memory_maps()
    if maps is None or maps[0] < _MOST_MAPS * maps[1]:
        return False
    import jax

    jax.clear_caches()
    gc.collect()
    return True


def _memory_maps() -> tuple[int, int] | None:
    """This process's memory maps, and how many it may have; None where no system tells."""
    try:
        with Path("/proc/self/maps").open("rb") as maps:
            return sum(1 for _ in maps), int(Path("/proc/sys/vm/max_map_count").read_text("ascii"))
    except (OSError, ValueError):
        return None


def _user_cache() -> Path:
    given = os.environ.get("XDG_CACHE_HOME", "")
    return Path(given) if Path(given).is_absolute() else Path.home() / ".cache"


def _processor() -> str:
    """A name for what this machine's processor can do."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines()
    except OSError:
        lines = []
    features = [line for line in lines if line.startswith(("model name", "flags", "Features", "CPU part"))]
    said = "\n".join([platform.machine(), platform.processor(), *dict.fromkeys(features)])
    return f"{platform.machine()}-{hashlib.sha256(said.encode()).hexdigest()[:12]}"


def quiet_xla() -> None:
    """Keep XLA's own log off the terminal; works until JAX is imported, and where the user has not chosen otherwise.

    On a processor with AVX-512, XLA warns at each program it loads from the cache that the machine does not support
    `+prefer-no-gather`, and may crash. That is a tuning preference, no instruction: https://github.com/jax-ml/jax/issues/38445
    What goes wrong in XLA also comes as an exception.
    """
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")


@dataclass
class Compilations:
    """Programs that JAX made ready, so far.

    Attributes:
        count: all of them, compiled or loaded from the cache on disk.
        cached: those loaded.
        seconds: the time it took.
    """

    count: int = 0
    cached: int = 0
    seconds: float = 0.0

    def on_duration(self, event: str, duration_secs: float, **_: str | int) -> None:
        """Listen to JAX: something took a time."""
        if event == _COMPILED:
            self.count += 1
            self.seconds += duration_secs

    def on_event(self, event: str, **_: str | int) -> None:
        """Listen to JAX: something happened."""
        if event == _FROM_CACHE:
            self.cached += 1


@contextmanager
def count_compilations() -> Iterator[Compilations]:
    """Count the programs that JAX compiles, in any thread, until the end of the block."""
    from jax import monitoring

    seen = Compilations()
    on_duration, on_event = seen.on_duration, seen.on_event
    monitoring.register_event_duration_secs_listener(on_duration)
    monitoring.register_event_listener(on_event)
    try:
        yield seen
    finally:
        monitoring.unregister_event_duration_listener(on_duration)
        monitoring.unregister_event_listener(on_event)
