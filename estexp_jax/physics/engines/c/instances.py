"""Where effects are at work: the sites and lanes whose values are not neutral, in arrays of a few common lengths."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from estexp_jax.physics.effects.base import Effect

_GROWTH = 8
"""Arrays have 8, 64, 512 ... entries, so that programs for few lengths are compiled."""


def padded_length(n: int) -> int:
    """The common length of arrays for `n` entries."""
    length = _GROWTH
    while length < n:
        length *= _GROWTH
    return length


def padded(x: np.ndarray) -> np.ndarray:
    """An array (n, ...) with its first entry repeated up to a common length."""
    index = np.zeros(padded_length(len(x)), int)
    index[: len(x)] = np.arange(len(x))
    return x[index]


class Instances(NamedTuple):
    """Sites and lanes where one effect is at work.

    Attributes:
        site: (n,) index of the site.
        lane: (n,).
        p: the parameters, an array (padded n,) each.
    """

    site: np.ndarray
    lane: np.ndarray
    p: tuple[np.ndarray, ...]

    @property
    def size(self) -> int:
        """Their number."""
        return len(self.lane)


def instances_of(effect: Effect, values: np.ndarray) -> Instances | None:
    """Where an effect is at work, from its values (lanes, n_sites, n_parameters); None where it is nowhere."""
    lane, site = np.nonzero(at_work(effect, values))
    if not lane.size:
        return None
    parameters = padded(values[lane, site].astype(float))
    return Instances(site, lane, tuple(np.ascontiguousarray(x) for x in parameters.T))


def at_work(effect: Effect, values: np.ndarray) -> np.ndarray:
    """Whether an effect is at work, (lanes, n_sites)."""
    neutral = np.array([p.neutral for p in effect.parameters], values.dtype)
    return (values != neutral).any(axis=2)
