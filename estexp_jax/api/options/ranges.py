"""Valid ranges and choices, written beside the option's type and checked before work begins.

duration: Annotated[float, Range(1.0, 600.0)] = 8.0
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal, SupportsFloat, SupportsIndex, final, get_args, get_origin, get_type_hints

from estexp_jax.errors import InputError, abbreviated, known


@final
@dataclass(frozen=True)
class Range:
    """The numbers that an option may have.

    Attributes:
        low: the smallest; None: there is none.
        high: the largest; None: there is none.
        open: whether `low` itself is left out.
        words: texts that may stand instead of a number.
    """

    low: float | None = None
    high: float | None = None
    open: bool = False
    words: tuple[str, ...] = ()

    def __contains__(self, value: float) -> bool:
        if value != value:  # NaN
            return False
        enough = self.low is None or value > self.low or (not self.open and value == self.low)
        return enough and (self.high is None or value <= self.high)

    def __str__(self) -> str:
        low, high = (None if end is None or abs(end) == math.inf else _in_words(end) for end in (self.low, self.high))
        if low is not None and high is not None:
            return f"{'more than ' if self.open else ''}{low} to {high}"
        if low is not None:
            return f"more than {low}" if self.open else f"at least {low}"
        return "any number" if high is None else f"at most {high}"


def _in_words(number: float) -> str:
    return f"{number:g}" if abs(number) < 1e6 else f"{number:,.0f}"


_LONG = 1e40
"""A message shows the beginning of numbers beyond this."""
SEEDS = Range(0, 2**32 - 1)
"""Of random numbers: what every generator takes."""


class CheckedOptions:
    """Options whose values are checked as soon as they are there."""

    def __post_init__(self) -> None:
        check_values(type(self), vars(self))


def check_values(options: type, values: Mapping[str, Any]) -> None:
    """See that values lie in the ranges and choices of an options class.

    Args:
        options: a dataclass whose fields are annotated with `Range` or `Literal`.
        values: by the names of its fields; None counts as not given.

    Raises:
        InputError: a number is out of its range, no number or no whole one; or a choice does not exist.
    """
    hints = get_type_hints(options, include_extras=True)
    for name, value in values.items():
        _check_value(f"--{name.replace('_', '-')}", value, tuple(_parts(hints[name])))


def _parts(hint: Any) -> Iterator[Any]:
    """The types, ranges and choices that an annotation consists of."""
    if get_origin(hint) is Literal:
        yield get_args(hint)
    elif get_origin(hint) is Annotated:
        inner, *notes = get_args(hint)
        yield from (note for note in notes if isinstance(note, Range))
        yield from _parts(inner)
    elif get_args(hint):
        for inner in get_args(hint):
            yield from _parts(inner)
    else:
        yield hint


def _check_value(where: str, value: Any, parts: tuple[Any, ...]) -> None:
    choices = [choice for part in parts if isinstance(part, tuple) for choice in part]
    kinds = [part for part in parts if part in (int, float)]
    if value is None or not (choices or kinds):
        return
    if choices:
        if value not in choices:
            raise InputError(f"there is no {abbreviated(value)}", where=where, right=known(choices))
    elif isinstance(value, str) or not hasattr(value, "__len__"):
        _check_number(where, value, float not in kinds, [part for part in parts if isinstance(part, Range)])
    else:
        for each in value:
            _check_value(where, each, parts)


def _check_number(where: str, value: Any, whole: bool, ranges: list[Range]) -> None:
    words = [word for each in ranges for word in each.words]
    if isinstance(value, str) and value in words:
        return
    if isinstance(value, bool) or not isinstance(value, SupportsIndex if whole else SupportsFloat):
        right = " or ".join(["a whole number" if whole else "a number", *map(repr, words)])
        raise InputError(f"{abbreviated(value)} is not possible", where=where, right=right)
    number = value if isinstance(value, int) else float(value)  # a whole number may be too large for a float
    for each in ranges:
        if number not in each:
            text = value if abs(number) < _LONG else abbreviated(value)
            raise InputError(f"{text} is not possible", where=where, right=str(each))
