"""The interface of worker pools: many independent calls at a time."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from typing import Any

Call = tuple[Callable[..., Any], tuple[Any, ...]]
"""A module-level function and its arguments; these and the result must pickle."""


class WorkerPool(AbstractContextManager["WorkerPool"], ABC):
    """Workers for independent calls. Leaving the context stops them."""

    @abstractmethod
    def each(self, calls: Sequence[Call]) -> Iterator[tuple[int, Any]]:
        """Run all calls, in any order.

        Yields:
            The index of a call and its result, as each call ends.

        Raises:
            Exception: as a call raised it.
        """

    @abstractmethod
    def summary(self) -> str:
        """The workers in words: `2 processes`."""
