"""Names for lists of bare numbers, such as commands in a `Float64MultiArray`, from lists of names elsewhere in a log.

A controller that takes bare numbers tells their order in another place: in a topic of its own namespace, in its
parameters, or in the labels of the array's layout. Names of any other topic say nothing, since their order is its own.
"""

from __future__ import annotations

import re
from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, final

from estexp_jax.recordings.readers.messages import MOST_VALUES, children, numbers_in

_MOST_MESSAGES = 200
"""Of a channel; its first ones are looked through."""
_DEEPEST = 6
_PARAMETERS = ("new_parameters", "changed_parameters")
_VALUE = re.compile(r"(.*)\[(\d+)\]$")


class Label(NamedTuple):
    """What a value of a list is called, and where that stands."""

    name: str
    place: str


class _Listed(NamedTuple):
    """Whose list of names it is, where it stands, and the names."""

    owner: str
    place: str
    names: tuple[str, ...]


@final
@dataclass(eq=False)
class NameLists:
    """The lists of names that a log's messages hold.

    Attributes:
        found: by owner (a topic, or the namespace of a controller) and place; empty where the names changed.
        counts: how many messages of each channel were looked through.
    """

    found: dict[tuple[str, str], tuple[str, ...]] = field(default_factory=dict)
    counts: dict[Hashable, int] = field(default_factory=dict)

    def add(self, key: Hashable, topic: str, message: Any) -> None:
        """Look a message through.

        Args:
            key: of its channel.
            topic: of it.
            message: decoded.
        """
        self.counts[key] = self.counts.get(key, 0) + 1
        if self.counts[key] > _MOST_MESSAGES:
            return
        for owner, place, names in (*_of_layout(topic, message), *_of_parameters(topic, message), *_of(topic, message)):
            known = self.found.setdefault((owner, place), names)
            if known != names:
                self.found[owner, place] = ()

    def labels(self, columns: Iterable[str]) -> dict[str, Label]:
        """The names of columns such as `/commands.data[2]`, where one list of as many names goes with theirs.

        Args:
            columns: of a log, all of them.
        """
        lists: dict[str, list[tuple[str, int]]] = {}
        for column in columns:
            if match := _VALUE.fullmatch(column):
                lists.setdefault(match[1], []).append((column, int(match[2])))
        labels: dict[str, Label] = {}
        for path, members in lists.items():
            if sorted(index for _, index in members) != list(range(len(members))):
                continue
            fitting = self._fitting(path, len(members))
            if len({names for _, names in fitting}) == 1:
                place, names = fitting[0]
                labels |= {column: Label(names[index], place) for column, index in members}
        return labels

    def _fitting(self, path: str, count: int) -> list[tuple[str, tuple[str, ...]]]:
        """Places and names of the lists that may go with one; those of its own message, else those called so."""
        topic = path.partition(".")[0]
        own, around = [], []
        for (owner, place), names in self.found.items():
            if len(names) == count == len(set(names)):
                own += [(place, names)] if owner == topic else []
                around += [(place, names)] if owner == topic.rpartition("/")[0] else []
        called = [each for each in around if "joint" in each[0].rpartition(".")[2].lower()]
        return own or called or around


def _of(topic: str, message: Any) -> Iterator[_Listed]:
    """The lists of texts in a message, which go with topics of its namespace.

    Beside lists of numbers they are the names of these, and say nothing about others of the root's namespace.
    """
    namespace = topic.rpartition("/")[0]
    if namespace or not any(path.endswith("]") for path in numbers_in(message)):
        yield from (_Listed(namespace, f"{topic}{place}", names) for place, names in _texts(message))


def _of_layout(topic: str, message: Any) -> Iterator[_Listed]:
    """The labels of an array's dimensions, one for each value."""
    dimensions = children(children(message).get("layout")).get("dim")
    labels = _texts_in([children(each).get("label") for each in _listed(dimensions)])
    if labels and all(labels):
        yield _Listed(topic, f"{topic}.layout.dim", labels)


def _of_parameters(topic: str, message: Any) -> Iterator[_Listed]:
    """The lists of joints among the parameters of a node, as `rcl_interfaces/ParameterEvent` tells them."""
    fields = children(message)
    node = fields.get("node")
    if not isinstance(node, str):
        return
    for kind in _PARAMETERS:
        for parameter in _listed(fields.get(kind)):
            name = children(parameter).get("name")
            names = _texts_in(children(children(parameter).get("value")).get("string_array_value"))
            if isinstance(name, str) and "joint" in name and names:
                yield _Listed(node, f"{topic}, {node}.{name}", names)


def _texts(message: Any, place: str = "", depth: int = 0) -> Iterator[tuple[str, tuple[str, ...]]]:
    """The lists of texts in the objects of a message, with their paths."""
    for name, value in children(message).items() if depth < _DEEPEST else ():
        if names := _texts_in(value):
            yield f"{place}.{name}", names
        else:
            yield from _texts(value, f"{place}.{name}", depth + 1)


def _texts_in(value: Any) -> tuple[str, ...]:
    """The texts of a list of nothing else, not too long; empty for other values."""
    short = _is_sequence(value) and 0 < len(value) <= MOST_VALUES
    return tuple(value) if short and all(isinstance(text, str) for text in value) else ()


def _listed(value: Any) -> Sequence[Any]:
    return value if _is_sequence(value) else ()


def _is_sequence(value: Any) -> bool:
    return hasattr(value, "__len__") and hasattr(value, "__getitem__") and not isinstance(value, str | bytes | Mapping)
