"""Many calls at a time: in this process, in processes of this machine, or on the machines of a Ray cluster."""

from __future__ import annotations

import multiprocessing
import os
import threading
import time
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from contextlib import AbstractContextManager
from typing import Any, final

from estexp_jax.errors import InputError

Call = tuple[Callable[..., Any], tuple[Any, ...]]
"""A function of a module, and its arguments. Both, and the result, travel to other processes."""
_LOOK = 1.0
"""Seconds between a worker's looks at whether it is still wanted."""


class WorkerPool(AbstractContextManager["WorkerPool"], ABC):
    """Workers for calls that do not depend on each other. Leaving the context sends them home."""

    @abstractmethod
    def each(self, calls: Sequence[Call]) -> Iterator[tuple[int, Any]]:
        """Do all calls, in any order.

        Yields:
            The index of a call and its result, as each ends.

        Raises:
            Exception: what a call raised.
        """

    @abstractmethod
    def about(self) -> str:
        """Who works, for a person: `2 processes`."""


@final
class SerialPool(WorkerPool):
    """This process, one call after the other."""

    def each(self, calls: Sequence[Call]) -> Iterator[tuple[int, Any]]:
        """Do all calls in their order."""
        for index, (function, arguments) in enumerate(calls):
            yield index, function(*arguments)

    def about(self) -> str:
        """In words."""
        return "this process"

    def __exit__(self, *_: object) -> None:
        pass


@final
class ProcessPool(WorkerPool):
    """Processes of this machine, each begun anew: what compiles must not be forked.

    They end with this one, also where it is killed.

    Args:
        number: of them.
    """

    def __init__(self, number: int) -> None:
        self._number = number

    def each(self, calls: Sequence[Call]) -> Iterator[tuple[int, Any]]:
        """Do all calls, as many at a time as there are processes."""
        spawned = multiprocessing.get_context("spawn")
        with ProcessPoolExecutor(self._number, spawned, _end_with, (os.getpid(),)) as pool:
            futures = {pool.submit(function, *arguments): i for i, (function, arguments) in enumerate(calls)}
            try:
                for future in as_completed(futures):
                    yield futures[future], future.result()
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise

    def about(self) -> str:
        """In words."""
        return f"{self._number} processes"

    def __exit__(self, *_: object) -> None:
        pass


def _end_with(parent: int) -> None:
    """In a worker: end with the process that began it, whatever the worker is at."""
    threading.Thread(target=_watch, args=(parent,), daemon=True).start()


def _watch(parent: int) -> None:
    while os.getppid() == parent:
        time.sleep(_LOOK)
    os._exit(1)


def worker_pool_of(workers: int | None = None, ray: str | None = None, paths: Sequence[str] = ()) -> WorkerPool:
    """The workers that the options ask for.

    Args:
        workers: how many calls at a time; None: one, and with Ray as many as its machines have room for.
        ray: address of a Ray cluster, `local` for one on this machine; None: without Ray.
        paths: where workers on other machines find the modules of the calls, if these are not installed there.

    Raises:
        InputError: there is no such number of workers, Ray is not installed, or nobody answers at the address.
    """
    if workers is not None and workers < 1:
        raise InputError(f"is {workers}", where="--workers", right="at least 1")
    if ray is not None:
        from estexp_jax.runs.cluster import RayPool

        return RayPool(ray, workers, paths)
    return SerialPool() if workers in (None, 1) else ProcessPool(workers)
