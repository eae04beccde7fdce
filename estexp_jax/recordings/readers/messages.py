"""Look up numbers in decoded messages, by paths such as `/joint_states.position[2]` or `.position[elbow]`."""

from __future__ import annotations

import dataclasses
import re
from array import array
from collections.abc import Iterator, Mapping, Sequence
from functools import lru_cache
from types import SimpleNamespace
from typing import Any, final

import numpy as np

MOST_VALUES = 64
"""Lists longer than this are images or point clouds, and are not listed as columns."""
_DEEPEST = 8
_ABSENT = object()
_OWN_NAME = "name"


@final
@dataclasses.dataclass(frozen=True)
class Named:
    """The step to the value of a list that bears a name, whatever its index in this message.

    Attributes:
        name: of a joint, say.
        field: of the list of names beside the values (`name`, `joint_names`), or of the name inside each value.
        depth: how many steps lead from the message to the object with that list; -1: each value has its own name.
    """

    name: str
    field: str
    depth: int


Step = str | int | Named
"""One step of a path: a field's name, an index, or a value's name."""


def path_in(message: Any, rest: str) -> tuple[Step, ...] | None:
    """The steps that lead from a message to a value.

    Args:
        message: a decoded message in which the path is looked up, since field names may contain dots.
        rest: the path after the topic: `.position[2]`, or `.position[elbow]` for the value of that name: the name
            stands at its index in a list of names of the same length, here or further out, or in the value itself.

    Returns:
        The steps; None if this message has no such value.
    """
    steps: list[Step] = []
    parents: list[Any] = []
    value = message
    while rest:
        fields = _field_names(value)
        if fields is not None and rest.startswith("."):
            fitting = [key for key in fields if rest[1:].startswith(key) and rest[1 + len(key) :][:1] in ("", ".", "[")]
            if not fitting:
                return None
            step: Step | None = max(fitting, key=len)
            following = rest[1 + len(str(step)) :]
        else:
            match = re.match(r"\[([^\[\]]+)\]", rest)
            if not match or not _is_list(value):
                return None
            inner, following = match[1], rest[match.end() :]
            step = int(inner) if inner.isdecimal() and len(inner) < 10 else _named(inner, value, parents)
        found = None if step is None else _after(step, value, [*parents, value])
        if step is None or found is None:
            return None
        steps.append(step)
        parents.append(value)
        value, rest = found, following
    return tuple(steps)


def follow(message: Any, steps: Sequence[Step]) -> Any:
    """The value at the end of a path; None if this message has none."""
    values = walked(message, steps)
    return None if values is None else values[-1]


def walked(message: Any, steps: Sequence[Step]) -> list[Any] | None:
    """The message and what each step of a path leads to; None if this message has no such path."""
    values = [message]
    for step in steps:
        value = _after(step, values[-1], values)
        if value is None:
            return None
        values.append(value)
    return values


def name_at(message: Any, steps: Sequence[Step]) -> str | None:
    """The name of the value that a path with an index leads to; None where nothing gives it one."""
    value, parents, name = message, [message], None
    for step in steps:
        if isinstance(step, int) and _is_list(value):
            names = names_beside(value, parents[:-1])
            name = names[step] if names is not None and step < len(names) else name
        value = _after(step, value, parents)
        if value is None:
            return None
        parents.append(value)
    return name


def message_number(value: Any) -> float | None:
    """A number, or a stamp of seconds and nanoseconds in s, as a float; None for other values."""
    if type(value) is float:
        return value
    if isinstance(value, bool | int | float | np.number | np.bool_):
        try:
            return float(value)
        except (OverflowError, TypeError):  # a complex number is a number to NumPy
            return None
    time = nanoseconds(value)
    return None if time is None else 1e-9 * time


def nanoseconds(stamp: Any) -> int | None:
    """A stamp such as ROS's `{sec, nanosec}`, or a number of seconds, in ns; None for other values."""
    if isinstance(stamp, int | float | np.number) and not isinstance(stamp, bool):
        number = float(stamp) if abs(stamp) < 9e9 else np.nan
        return round(1e9 * number) if np.isfinite(number) else None
    fields = _field_names(stamp) or ()
    parts = []
    for names in (("sec", "secs", "seconds"), ("nanosec", "nsec", "nsecs", "nanos")):
        found = [_get(stamp, name) for name in names if name in fields]
        if not found or not isinstance(found[0], int | np.integer) or isinstance(found[0], bool):
            return None
        parts.append(int(found[0]))
    return parts[0] * 1_000_000_000 + parts[1] if abs(parts[0]) < 9e9 and abs(parts[1]) < 1e10 else None


def numbers_in(message: Any, parents: tuple[Any, ...] = ()) -> Iterator[str]:
    """Paths, after the topic, to all numbers in a message; by name where the values of a list have names."""
    fields = _field_names(message)
    if len(parents) > _DEEPEST:
        return
    if fields is not None:
        for key in fields:
            yield from (f".{key}{rest}" for rest in numbers_in(_get(message, key), (*parents, message)))
    elif _is_list(message) and len(message) <= MOST_VALUES:
        names = names_beside(message, parents)
        for index, value in enumerate(message):
            plain = names is None or names[index].isdecimal() or re.search(r"[\[\]]", names[index])
            key = index if plain or names is None else names[index]
            yield from (f"[{key}]{rest}" for rest in numbers_in(value, (*parents, message)))
    elif message_number(message) is not None:
        yield ""


def _after(step: Step, value: Any, parents: Sequence[Any]) -> Any:
    """The value one step on; None if there is none. `parents` begin with the message and end with `value`."""
    if isinstance(step, str):
        found = _get(value, step)
        return None if found is _ABSENT else found
    if not _is_list(value):
        return None
    index = step if isinstance(step, int) else _index(step, value, parents)
    return value[index] if index is not None and index < len(value) else None


def _index(step: Named, values: Any, parents: Sequence[Any]) -> int | None:
    """Where a name stands in this message; ROS does not guarantee a constant order."""
    if step.depth < 0:
        return next((k for k, value in enumerate(values) if _get(value, step.field) == step.name), None)
    names = listed_names(step, values, parents)
    return names.index(step.name) if names is not None and step.name in names else None


def listed_names(step: Named, values: Any, parents: Sequence[Any]) -> list[str] | None:
    """The list of names that a step goes by, in this message; None if it has no such list of the values' length."""
    names = _get(parents[step.depth], step.field)
    if type(names) is not list:
        names = list(names) if isinstance(names, tuple) or (names is not _ABSENT and _is_list(names)) else None
    return names if names is not None and _is_list(values) and len(names) == len(values) else None


def _named(name: str, values: Any, parents: Sequence[Any]) -> Named | None:
    """The step to the value of this name; `parents` begin with the message and end with what holds the values."""
    if any(_get(value, _OWN_NAME) == name for value in values):
        return Named(name, _OWN_NAME, -1)
    for depth in reversed(range(len(parents))):
        for field in _lists_of_names(parents[depth], len(values)):
            if name in _get(parents[depth], field):
                return Named(name, field, depth)
    return None


def names_beside(values: Any, parents: Sequence[Any]) -> list[str] | None:
    """The names of a list's values, all different; None if they have none."""
    if not _is_list(values) or not len(values):
        return None
    named = len(values) <= MOST_VALUES and _field_names(values[0]) is not None
    own = [_get(value, _OWN_NAME) for value in values] if named else []
    if own and all(isinstance(name, str) for name in own):
        return own if len(set(own)) == len(own) else None
    for parent in reversed(parents):
        for field in _lists_of_names(parent, len(values)):
            names = list(_get(parent, field))
            if len(set(names)) == len(names) and _get(parent, field) is not values:
                return names
    return None


def _lists_of_names(parent: Any, length: int) -> list[str]:
    """Fields of an object that hold as many texts as a list has values; those called after names first."""
    texts = {field: each for field, each in children(parent).items() if length and _is_list(each)}
    found = [k for k, each in texts.items() if len(each) == length and all(isinstance(text, str) for text in each)]
    return sorted(found, key=lambda field: "name" not in field.lower())


def _get(value: Any, key: str) -> Any:
    if isinstance(value, Mapping):
        return value.get(key, _ABSENT)
    return getattr(value, key, _ABSENT) if key in (_slots(type(value)) or ()) else _ABSENT


def children(value: Any) -> dict[str, Any]:
    """The fields of a message or object; none of other values."""
    return {name: _get(value, name) for name in _field_names(value) or ()}


def _field_names(value: Any) -> Sequence[str] | None:
    if isinstance(value, Mapping):
        return [key for key in value if isinstance(key, str)]
    return _slots(type(value))


@lru_cache(maxsize=1000)
def _slots(kind: type) -> tuple[str, ...] | None:
    """The fields of a class of messages: of mcap_ros2, rosbags or protobuf; None for other values."""
    if issubclass(kind, SimpleNamespace):
        return tuple(getattr(kind, "__slots__", ()))
    if dataclasses.is_dataclass(kind):
        return tuple(field.name for field in dataclasses.fields(kind) if not field.name.startswith("_"))
    fields = getattr(getattr(kind, "DESCRIPTOR", None), "fields", None)
    return None if fields is None else tuple(field.name for field in fields)


def _is_list(value: Any) -> bool:
    if isinstance(value, list | tuple | array | bytes):
        return True
    if isinstance(value, np.ndarray):
        return value.ndim == 1
    return isinstance(value, Sequence) and not isinstance(value, str)
