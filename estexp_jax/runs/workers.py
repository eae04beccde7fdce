"""Many calls at a time: in this process, in processes of this machine, or on the machines of a Ray cluster."""

from __future__ import annotations

import multiprocessing
import os
import threading
import time
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from typing import Any, final

from estexp_jax.errors import InputError
from estexp_jax.runs.worker_pool import Call, WorkerPool

_POLL_S = 1.0
"""Period at which a worker checks that its parent is alive, s."""


@final
class SerialPool(WorkerPool):
    """This process, one call after the other."""

    def each(self, calls: Sequence[Call]) -> Iterator[tuple[int, Any]]:
        """Run all calls in order."""
        for index, (function, arguments) in enumerate(calls):
            yield index, function(*arguments)

    def summary(self) -> str:
        """In words."""
        return "this process"

    def __exit__(self, *_: object) -> None:
        pass


@final
class ProcessPool(WorkerPool):
    """Processes of this machine, spawned, since processes that compile must not be forked.

    They end with this process, even if it is killed.

    Args:
        number: of them.
    """

    def __init__(self, number: int) -> None:
        self._number = number

    def each(self, calls: Sequence[Call]) -> Iterator[tuple[int, Any]]:
        """Run all calls, as many at a time as there are processes."""
        spawned = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(self._number, spawned, _start_watch, (os.getpid(),)) as pool:
            futures = {pool.submit(function, *arguments): i for i, (function, arguments) in enumerate(calls)}
            try:
                for future in as_completed(futures):
                    yield futures[future], future.result()
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise

    def summary(self) -> str:
        """In words."""
        return f"{self._number} processes"

    def __exit__(self, *_: object) -> None:
        pass


def _start_watch(parent: int) -> None:
    """In a worker: exit when the parent process ends, whatever the worker is doing."""
    threading.Thread(target=_exit_with_parent, args=(parent,), daemon=True).start()


def _exit_with_parent(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_POLL_S)
    os._exit(1)


def worker_pool_of(workers: int | None = None, ray: str | None = None, paths: Sequence[str] = ()) -> WorkerPool:
    """The worker pool that the options ask for.

    Args:
        workers: number of calls at a time; None: one, or with Ray as many as its machines have room for.
        ray: address of a Ray cluster, `local` for one on this machine; None: without Ray.
        paths: folders in which workers on other machines find the modules of the calls, if not installed there.

    Raises:
        InputError: the number of workers is not positive, Ray is not installed, or the address does not answer.
    """
    if workers is not None and workers < 1:
        raise InputError(f"is {workers}", where="--workers", right="at least 1")
    if ray is not None:
        from estexp_jax.runs.cluster import RayPool

        return RayPool(ray, workers, paths)
    return SerialPool() if workers in (None, 1) else ProcessPool(workers)
