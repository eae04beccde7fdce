"""What candidates would add to predictions of held-out stretches, beside a joint fit and in place of its effects."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from estexp_jax.discovery.joint.candidates import Candidate
from estexp_jax.discovery.joint.held_out import HeldOut, HeldOutGain
from estexp_jax.estimation.parameters import Place


class Proposal(NamedTuple):
    """An effect that might be added, at a multiple of its guess; `instead_of` another, or of none.

    Its `price` is what its numbers cost, nats: of two that gain alike the one with fewer is taken.
    """

    candidate: Candidate
    instead_of: Place | None
    gain: HeldOutGain
    price: float


def proposed(
    held_out: HeldOut,
    base: np.ndarray,
    groups: Mapping[Place, np.ndarray],
    tried: Sequence[Candidate],
    wanted: Sequence[int],
    first: int,
) -> list[Proposal]:
    """What candidates add, the best first, beside a fit and in place of each of its effects, to predictions held out.

    Args:
        held_out: the windows about the fit.
        base: columns of the fit.
        groups: of these, the columns of each place.
        tried: the candidates.
        wanted: indices of those that are asked for.
        first: column of the first candidate.
    """
    columns = first + np.asarray(wanted, dtype=int)
    least, most = (np.array([getattr(tried[i], end) for i in wanted]) for end in ("least", "most"))
    found = []
    for place in (None, *groups):
        gone = groups[place] if place else np.zeros(0, int)
        gains = held_out.gains_of(columns, base, gone, least, most)
        each = 0.5 * np.log(max(held_out.linear.observations, 1.0))
        found += [Proposal(tried[i], place, g, each * tried[i].numbers) for i, g in zip(wanted, gains, strict=True)]
    return sorted(found, key=lambda p: p.price - p.gain.total)
