"""Where effects are at work: the sites and lanes whose values are not neutral."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from estexp_jax.physics.effects.base import Effect


class Instances(NamedTuple):
    """Sites and lanes where one effect is at work.

    Attributes:
        site: (n,) index of the site, or of the element on which it acts.
        lane: (n,).
        p: the parameters, an array (n,) each.
    """

    site: np.ndarray
    lane: np.ndarray
    p: tuple[np.ndarray, ...]


def instances_of(effect: Effect, values: np.ndarray) -> Instances | None:
    """Where an effect is at work, from its values (lanes, n_sites, n_parameters), or at elements; None: nowhere."""
    lane, site = np.nonzero(at_work(effect, values))
    if not lane.size:
        return None
    return Instances(site, lane, tuple(np.ascontiguousarray(x) for x in values[lane, site].astype(float).T))


def at_work(effect: Effect, values: np.ndarray) -> np.ndarray:
    """Whether an effect is at work, (lanes, n_sites)."""
    neutral = np.array([p.neutral for p in effect.parameters], values.dtype)
    return (values != neutral).any(axis=2)
