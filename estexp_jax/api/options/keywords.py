"""Keywords of the Python doors: a wrong one is an `InputError` that lists those that exist."""

from __future__ import annotations

import functools
from collections.abc import Callable, Sequence
from difflib import SequenceMatcher
from inspect import Parameter, signature
from typing import ParamSpec, TypeVar

from estexp_jax.api.options.ranges import check_values
from estexp_jax.errors import InputError, known, name_too_long

_P = ParamSpec("_P")
_R = TypeVar("_R")


def front_door(options: type | None = None) -> Callable[[Callable[_P, _R]], Callable[_P, _R]]:
    """Make a function a door of the package: its keywords, and the values that `options` has ranges for, are checked.

    Args:
        options: the command's dataclass; None where there is no such command.

    Returns:
        A decorator. The function it returns raises `InputError` before it does anything.
    """

    def decorate(function: Callable[_P, _R]) -> Callable[_P, _R]:
        parameters = signature(function).parameters.values()
        keywords = [p.name for p in parameters if p.kind in (Parameter.KEYWORD_ONLY, Parameter.POSITIONAL_OR_KEYWORD)]
        checked = set(keywords) & set(getattr(options, "__dataclass_fields__", ()))

        @functools.wraps(function)
        def door(*args: _P.args, **kwargs: _P.kwargs) -> _R:
            for name in kwargs:
                if name not in keywords:
                    raise unknown_keyword(name, function.__name__, keywords)
            if options is not None:
                check_values(options, {name: value for name, value in kwargs.items() if name in checked})
            try:
                return function(*args, **kwargs)
            except OSError as error:
                told = name_too_long(error)
                if told is None:
                    raise
                raise told from error

        return door

    return decorate


def unknown_keyword(name: str, door: str, keywords: Sequence[str]) -> InputError:
    """The message about a keyword that a door does not have; the nearest one that it has comes first."""
    nearest = sorted(keywords, key=lambda keyword: -SequenceMatcher(None, name, keyword).ratio())
    ordered = dict.fromkeys([*nearest[:1], *keywords])
    return InputError(f"has no keyword '{name}'", where=f"{door}()", right=known(ordered))
