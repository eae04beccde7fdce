"""Hypotheses as sets of options with amounts, and their neighbours.

Each function returns neighbours of some hypotheses; `set_search` decides which of them are kept.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

import numpy as np

OptionAmount = tuple[int, float]
"""Index of an option, and its amount."""
OptionSet = tuple[OptionAmount, ...]
"""A hypothesis: options with amounts, sorted, each option once; empty for the nominal model."""


@final
@dataclass(frozen=True)
class Option:
    """A candidate difference, such as an effect at a site.

    Attributes:
        low, high: range of its amount; equal if the amount is fixed.
        coarse: amounts that are tried first.
    """

    low: float
    high: float
    coarse: tuple[float, ...]


def grown(options: Sequence[Option], base: OptionSet) -> list[OptionSet]:
    """A hypothesis with each further option added, at each of its coarse amounts."""
    inside = {option for option, _ in base}
    return [
        tuple(sorted((*base, (index, amount))))
        for index, option in enumerate(options)
        if index not in inside
        for amount in option.coarse
    ]


def pruned(hypotheses: Sequence[OptionSet]) -> list[OptionSet]:
    """Hypotheses with each of their members removed."""
    return [items[:i] + items[i + 1 :] for items in hypotheses for i in range(len(items))]


def swapped(options: Sequence[Option], hypotheses: Sequence[OptionSet]) -> list[OptionSet]:
    """Hypotheses with each member of fixed amount replaced by each other such option, such as a smaller lost part."""
    whole = [(index, option.low) for index, option in enumerate(options) if option.low == option.high]
    asked = []
    for items in hypotheses:
        others = [item for item in whole if item not in items]
        for i, member in enumerate(items):
            if member in whole:
                asked += [tuple(sorted((*items[:i], other, *items[i + 1 :]))) for other in others]
    return asked


def around(options: Sequence[Option], hypotheses: Sequence[OptionSet], step: float) -> list[OptionSet]:
    """Hypotheses with each amount moved by up to four steps; `step` is a share of the amount's range.

    Sign flips of touch sensors cause many local minima, hence several steps.
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


def scanned(options: Sequence[Option], hypotheses: Sequence[OptionSet]) -> list[OptionSet]:
    """Hypotheses with each amount at every percent: the minimum may be narrow or behind larger residuals."""
    asked = []
    for items in hypotheses:
        for i, (index, _) in enumerate(items):
            option = options[index]
            percents = np.arange(round(100 * option.low), round(100 * option.high) + 1)
            asked += [(*items[:i], (index, int(p) / 100), *items[i + 1 :]) for p in percents]
    return asked


def rounded(hypotheses: Sequence[OptionSet]) -> list[OptionSet]:
    """Hypotheses with all amounts rounded to percent, and with each alone: planted damage has round numbers."""
    asked = []
    for items in hypotheses:
        whole = tuple((index, round(amount, 2)) for index, amount in items)
        asked += [whole, *(items[:i] + whole[i : i + 1] + items[i + 1 :] for i in range(len(items)))]
    return asked
