"""Ranges and choices of options: what is in them, and what a value out of them is answered."""

from dataclasses import dataclass
from typing import Annotated, Literal

import numpy as np
import pytest

from estexp_jax.api.options.ranges import CheckedOptions, Range
from estexp_jax.errors import InputError


@dataclass(frozen=True)
class Example(CheckedOptions):
    """Options of every kind."""

    duration: Annotated[float, Range(1.0, 600.0)] = 8.0
    window: Annotated[float | str, Range(0.0, open=True, words=("full",))] = 2.0
    n_rows: Annotated[int | None, Range(1)] = None
    sizes: Annotated[tuple[int, ...], Range(1, 9)] = ()
    engine: Literal["auto", "lanes"] = "auto"
    name: str = ""
    quick: bool = False


@pytest.mark.parametrize(
    "given",
    [
        {"duration": 1.0},
        {"duration": 600},
        {"window": "full"},
        {"window": float("inf")},
        {"n_rows": 1},
        {"sizes": (1, 9)},
        {"engine": "lanes"},
        {"n_rows": np.int64(3), "duration": np.float32(2.0)},
        {"name": "7", "quick": True},
    ],
)
def test_possible_values_pass(given):
    made = Example(**given)
    assert {name: getattr(made, name) for name in given} == given


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"duration": 0.5}, "--duration: 0.5 is not possible; 1 to 600"),
        ({"duration": float("nan")}, "--duration: nan is not possible; 1 to 600"),
        ({"duration": "long"}, "--duration: 'long' is not possible; a number"),
        ({"window": 0.0}, "--window: 0.0 is not possible; more than 0"),
        ({"window": "half"}, "--window: 'half' is not possible; a number or 'full'"),
        ({"n_rows": 0}, "--n-rows: 0 is not possible; at least 1"),
        ({"n_rows": 1.5}, "--n-rows: 1.5 is not possible; a whole number"),
        ({"sizes": (4, 0)}, "--sizes: 0 is not possible; 1 to 9"),
        ({"n_rows": True}, "--n-rows: True is not possible; a whole number"),
        ({"sizes": np.array([4, 0])}, "--sizes: 0 is not possible; 1 to 9"),
        ({"engine": "magic"}, "--engine: there is no 'magic'; known are: auto, lanes"),
    ],
)
def test_impossible_values_are_refused_with_their_range(given, message):
    with pytest.raises(InputError) as refused:
        Example(**given)
    assert str(refused.value) == message


@pytest.mark.parametrize(
    ("limits", "text"),
    [((None, None), "any number"), ((None, 3), "at most 3"), ((2, None), "at least 2"), ((2, 3), "2 to 3")],
)
def test_a_range_says_what_is_in_it(limits, text):
    assert str(Range(*limits)) == text
