"""Keep compiled programs between runs, and count compilations."""

from __future__ import annotations

import gc
import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from estexp_jax.lanes.processor import processor_name

_COMPILED = "/jax/core/compile/backend_compile_duration"
_FROM_CACHE = "/jax/compilation_cache/cache_hits"
_MAP_LIMIT = 0.5
"""Share of the allowed memory maps of a process above which compiled programs are dropped."""


def enable_compilation_cache() -> Path | None:
    """Keep programs that took long to compile on disk, so that the next run loads them.

    They go to `estexp_jax/xla` in the user's cache folder (`XDG_CACHE_HOME`, else `~/.cache`), in a folder for this
    kind of processor. JAX's own key does not distinguish processors, so machines with a shared home would load each
    other's programs. A cache that is already configured, or `JAX_COMPILATION_CACHE_DIR` (empty: none), is unchanged. A
    folder that cannot be written only costs time, so it is a one-line warning. Front doors call this, never an import.

    Returns:
        The folder in use; None without a cache.
    """
    import jax

    configured = jax.config.jax_compilation_cache_dir  # pyright: ignore[reportAttributeAccessIssue] (made at run time)
    if configured or "JAX_COMPILATION_CACHE_DIR" in os.environ:
        return Path(configured) if configured else None
    try:
        folder = compilation_cache_folder()
    except (OSError, RuntimeError) as error:  # RuntimeError: there is no home
        print(f"estexp: warning: compiled programs are not kept for the next run: {error}", file=sys.stderr)
        return None
    jax.config.update("jax_compilation_cache_dir", str(folder))
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0.5)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    return folder


def compilation_cache_folder() -> Path:
    """The user's folder of compiled programs for this kind of processor, made if it is not there.

    Raises:
        OSError: if it cannot be made or written.
        RuntimeError: if the user has no home.
    """
    folder = _user_cache() / "estexp_jax" / "xla" / processor_name()
    folder.mkdir(parents=True, exist_ok=True)
    if not os.access(folder, os.W_OK | os.X_OK):
        raise PermissionError(f"{folder} may not be written")
    return folder


def forget_programs() -> bool:
    """Drop compiled programs if this process is close to the limit of memory maps.

    JAX keeps each program for the life of the process, and each needs some memory maps. Linux allows 65530 of them;
    above that, the process crashes. Hundreds of explained recordings in one process reach the limit. Programs that are
    still needed are compiled again, or read from the cache on disk.

    Returns:
        Whether programs were dropped.
    """
    maps = _memory_maps()
    if maps is None or maps[0] < _MAP_LIMIT * maps[1]:
        return False
    import jax

    jax.clear_caches()
    gc.collect()
    return True


def _memory_maps() -> tuple[int, int] | None:
    """This process's number of memory maps and its limit; None if the system does not report them."""
    try:
        with Path("/proc/self/maps").open("rb") as maps:
            return sum(1 for _ in maps), int(Path("/proc/sys/vm/max_map_count").read_text("ascii"))
    except (OSError, ValueError):
        return None


def _user_cache() -> Path:
    given = os.environ.get("XDG_CACHE_HOME", "")
    return Path(given) if Path(given).is_absolute() else Path.home() / ".cache"


def quiet_xla() -> None:
    """Keep XLA's own log off the terminal. It must be called before JAX is imported, and the user's setting wins.

    On processors with AVX-512, XLA warns for each program from the cache that the machine does not support
    `+prefer-no-gather`, and may crash. That is only a tuning preference: https://github.com/jax-ml/jax/issues/38445
    Errors in XLA are raised as exceptions in any case.
    """
    os.environ.setdefault("TF_CPP_MIN_LOG_LEVEL", "3")


@dataclass
class Compilations:
    """Programs that JAX has prepared so far.

    Attributes:
        count: all programs, compiled or loaded from the cache on disk.
        cached: loaded programs.
        seconds: time spent, s.
    """

    count: int = 0
    cached: int = 0
    seconds: float = 0.0

    def on_duration(self, event: str, duration_secs: float, **_: str | int) -> None:
        """Listener for JAX's durations."""
        if event == _COMPILED:
            self.count += 1
            self.seconds += duration_secs

    def on_event(self, event: str, **_: str | int) -> None:
        """Listener for JAX's events."""
        if event == _FROM_CACHE:
            self.cached += 1


@contextmanager
def count_compilations() -> Iterator[Compilations]:
    """Count the programs that JAX compiles, in any thread, until the end of the block."""
    from jax import monitoring

    compilations = Compilations()
    on_duration, on_event = compilations.on_duration, compilations.on_event
    monitoring.register_event_duration_secs_listener(on_duration)
    monitoring.register_event_listener(on_event)
    try:
        yield compilations
    finally:
        monitoring.unregister_event_duration_listener(on_duration)
        monitoring.unregister_event_listener(on_event)
