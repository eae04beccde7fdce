"""Hypotheses as sets of options with amounts, and the ways from one to its neighbours.

Each function here gives the neighbours of some hypotheses; which of them to go on with is `set_search`'s to decide.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

Item = tuple[int, float]
"""Index of an option, and its amount."""
Items = tuple[Item, ...]
"""A hypothesis: sorted by option, each once; empty for "nothing differs"."""


@final
@dataclass(frozen=True)
class Option:
    """Something that may differ.

    Attributes:
        low, high: of its amount; equal where there is nothing to choose.
        coarse: amounts to try first.
    """

    low: float
    high: float
    coarse: tuple[float, ...]


def grown(options: Sequence[Option], base: Items) -> list[Items]:
    """A hypothesis with one member more, in every way."""
    inside = {option for option, _ in base}
    return [
        tuple(sorted((*base, (index, amount))))
        for index, option in enumerate(options)
        if index not in inside
        for amount in option.coarse
    ]


def pruned(hypotheses: Sequence[Items]) -> list[Items]:
    """Hypotheses with one member less."""
    return [items[:i] + items[i + 1 :] for items in hypotheses for i in range(len(items))]


def swapped(options: Sequence[Option], hypotheses: Sequence[Items]) -> list[Items]:
    """Each member that has no amount exchanged for each other such option: what is lost may be more, or less."""
    whole = [(index, option.low) for index, option in enumerate(options) if option.low == option.high]
    asked = []
    for items in hypotheses:
        others = [item for item in whole if item not in items]
        for i, member in enumerate(items):
            if member in whole:
                asked += [tuple(sorted((*items[:i], other, *items[i + 1 :]))) for other in others]
    return asked


def around(options: Sequence[Option], hypotheses: Sequence[Items], step: float) -> list[Items]:
    """Each amount up to four steps up and down; steps are shares of the amount's range.

    So many, because a touch sensor's flips leave local minima all along the way.
    """
    asked = []
    for items in hypotheses:
        for i, (index, amount) in enumerate(items):
            option = options[index]
            if option.high > option.low:
                moves = step * (option.high - option.low) * np.array([-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0])
                tried = np.unique(np.clip(amount + moves, option.low, option.high))
                asked += [(*items[:i], (index, float(a)), *items[i + 1 :]) for a in tried if a != amount]
    return asked


def scanned(options: Sequence[Option], hypotheses: Sequence[Items]) -> list[Items]:
    """Each amount at every percent: the way to the truth may lead through worse residuals, or be a few percent wide."""
    asked = []
    for items in hypotheses:
        for i, (index, _) in enumerate(items):
            option = options[index]
            percents = np.arange(round(100 * option.low), round(100 * option.high) + 1)
            asked += [(*items[:i], (index, int(p) / 100), *items[i + 1 :]) for p in percents]
    return asked


def rounded(hypotheses: Sequence[Items]) -> list[Items]:
    """All amounts to the percent, and each alone: what people break, they break by round numbers."""
    asked = []
    for items in hypotheses:
        whole = tuple((index, round(amount, 2)) for index, amount in items)
        asked += [whole, *(items[:i] + whole[i : i + 1] + items[i + 1 :] for i in range(len(items)))]
    return asked
