"""Ranges and choices of options: what is in them, and what a value out of them is answered."""

import math
from dataclasses import dataclass
from typing import Annotated, Literal, get_type_hints

import numpy as np
import pytest

from estexp_jax.api.options.ranges import CheckedOptions, Range, check_values
from estexp_jax.cli.commands import COMMANDS
from estexp_jax.errors import InputError
from experiments.robustness.arguments.draw import options_of, parts_of


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


def ranges_of(command: str) -> dict[str, tuple[Range, bool]]:
    """The range of each option that is a number, and whether it is a whole one."""
    found = {}
    for name, hint in get_type_hints(options_of(command), include_extras=True).items():
        every = tuple(parts_of(hint))
        if {int, float} & {part for part in every if isinstance(part, type)}:
            [limits] = [part for part in every if isinstance(part, Range)]
            found[name] = limits, float not in every
    return found


@pytest.mark.parametrize("command", COMMANDS)
def test_every_number_of_every_command_has_a_range_with_two_ends(command):
    options = options_of(command)
    for name, (limits, whole) in ranges_of(command).items():
        assert limits.low is not None and limits.high is not None, name
        step = 1 if whole else 1e-9
        for value in (limits.low - step, limits.high + step, -1e308, float("nan"), 10**400, -(10**400), "", "x"):
            if value in limits if isinstance(value, float) else limits.high == math.inf and value == 10**400:
                continue
            with pytest.raises(InputError, match=f"--{name.replace('_', '-')}"):
                check_values(options, {name: value})
        inner = limits.low + step if limits.open else limits.low
        for value in (inner, limits.high):
            check_values(options, {name: int(value) if whole else value})


def test_a_huge_number_is_told_by_its_beginning():
    with pytest.raises(InputError) as refused:
        Example(n_rows=-(10**400))
    assert len(str(refused.value)) < 200 and "--n-rows" in str(refused.value)
    with pytest.raises(InputError, match="0 to 4,294,967,295"):
        check_values(options_of("record"), {"seed": 2**32})
