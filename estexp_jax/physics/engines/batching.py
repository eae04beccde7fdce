"""One compiled function over any number of robots: equal chunks, one thread a core.

XLA's own threads do not split a batch of MJX steps over cores; several calls of one executable from Python threads do.
Every chunk has the same width, so that one compilation serves every population.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from typing import Any, NamedTuple

import jax
import numpy as np


class EngineChoice(NamedTuple):
    """An engine, and why it.

    Attributes:
        engine: its name.
        reason: why it is this one.
        largest_difference: from plain MuJoCo on the user's robot, relative; None where it was not compared.
    """

    engine: str
    reason: str
    largest_difference: float | None = None


def cores() -> int:
    """Number of processor cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else (os.cpu_count() or 1)


def in_chunks(function: Callable[[Any], Any], batch: Any, width: int) -> Any:
    """Apply a batched function to a batch of any size.

    Args:
        function: takes and returns pytrees whose arrays have `width` as first axis.
        batch: pytree of arrays (n, ...), n >= 1.
        width: size of a chunk; the last one is filled up with copies of the first robot.

    Returns:
        A pytree of numpy arrays (n, ...).
    """
    n = jax.tree.leaves(batch)[0].shape[0]
    offsets = range(0, n, width)

    def run(start: int) -> Any:
        chosen = np.arange(start, start + width)
        chosen[chosen >= n] = 0
        return jax.tree.map(np.asarray, function(jax.tree.map(lambda x: np.asarray(x)[chosen], batch)))

    if len(offsets) == 1:
        parts = [run(0)]
    else:
        with ThreadPoolExecutor(min(cores(), len(offsets))) as threads:
            parts = list(threads.map(run, offsets))
    return jax.tree.map(lambda *xs: np.concatenate(xs)[:n], *parts)
