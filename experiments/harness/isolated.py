"""Calls in a process of their own, which may end or hang: that is a result as well."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from typing import Any


def isolated(
    function: Callable[..., dict[str, Any]], calls: Iterable[tuple[Any, ...]], patience_s: float
) -> Iterator[dict[str, Any]]:
    """What a function says of each of some arguments, one after another; `crashed` where its process ended or hangs.

    Args:
        function: of a module, so that another process finds it.
        calls: its arguments.
        patience_s: after which a call is given up, s.
    """
    pool = _new_pool()
    try:
        for call in calls:
            try:
                yield pool.submit(function, *call).result(patience_s)
                continue
            except BrokenProcessPool:
                message = "the process ended"
            except TimeoutError:
                message = f"no end within {patience_s:.0f} s"
            except Exception as error:  # of the function itself
                yield {"result": "crashed", "message": f"{type(error).__name__}: {error}"[:300]}
                continue
            _end(pool)
            pool = _new_pool()
            yield {"result": "crashed", "message": message}
    finally:
        _end(pool)


def _new_pool() -> ProcessPoolExecutor:
    return ProcessPoolExecutor(1, get_context("spawn"))


def _end(pool: ProcessPoolExecutor) -> None:
    processes = list((pool._processes or {}).values())
    pool.shutdown(wait=False, cancel_futures=True)
    for process in processes:
        process.kill()
