"""The columns of one channel of messages: those that lie in one list or object are looked up together."""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Any, final

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.messages import (
    Named,
    Step,
    listed_names,
    message_number,
    name_at,
    names_beside,
    path_in,
    walked,
)

Decode = Callable[[Any], Any]


@final
@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of one column in order of the file: time in ns, by one clock, and value."""

    clock: str
    times: array = field(default_factory=lambda: array("q"))
    values: array = field(default_factory=lambda: array("d"))


@final
@dataclass(eq=False)
class _Group:
    """Columns that differ in their paths' last step only.

    Attributes:
        prefix: the steps before it.
        members: the last step of each column, by its path.
        names: by the place of a list of names, that list in the message before, and where members stood in it.
        first_names: at paths with an index, the name of the value that it led to first.
    """

    prefix: tuple[Step, ...]
    members: dict[str, Step] = field(default_factory=dict)
    names: dict[tuple[int, str], tuple[list[str], list[tuple[str, int]]]] = field(default_factory=dict)
    first_names: dict[str, str | None] = field(default_factory=dict)

    def add(self, rest: str, step: Step) -> None:
        """One more column."""
        self.members[rest] = step
        self.names.clear()

    def samples_in(self, message: Any, where: str) -> Iterator[tuple[str, float]]:
        """The number at each path for which this message has one.

        Raises:
            InputError: an index leads to a value of another name than before.
        """
        parents = walked(message, self.prefix)
        if parents is None:
            return
        self._check_indices(message, parents, where)
        places: dict[tuple[int, str], Named] = {}
        for rest, step in self.members.items():
            if isinstance(step, Named) and step.depth >= 0:
                places[step.depth, step.field] = step
                continue
            path = (
                walked(parents[-1], (step,)) if not isinstance(step, Named) else walked(message, (*self.prefix, step))
            )
            number = message_number(path[-1]) if path is not None else None
            if number is not None:
                yield rest, number
        for place, step in places.items():
            values = parents[-1]
            for rest, index in self._named(place, listed_names(step, values, parents)):
                number = message_number(values[index])
                if number is not None:
                    yield rest, number

    def _named(self, place: tuple[int, str], names: list[str] | None) -> list[tuple[str, int]]:
        """Where the members stand; names are looked through only if they are others than in the message before."""
        if names is None:
            return []
        before = self.names.get(place)
        if before is None or before[0] != names:
            indices = {name: k for k, name in reversed(list(enumerate(names)))}
            steps = [
                (rest, s) for rest, s in self.members.items() if isinstance(s, Named) and (s.depth, s.field) == place
            ]
            before = names, [(rest, indices[s.name]) for rest, s in steps if s.name in indices]
            self.names[place] = before
        return before[1]

    def _check_indices(self, message: Any, parents: list[Any], where: str) -> None:
        indices = any(type(step) is int for step in self.members.values())
        outer = any(type(step) is int for step in self.prefix)
        if not indices and not outer:
            return
        names = names_beside(parents[-1], parents[:-1]) if indices else None
        around = name_at(message, self.prefix) if outer else None
        for rest, step in self.members.items():
            own = names[step] if names is not None and isinstance(step, int) and step < len(names) else None
            name, first = own or around, self.first_names.setdefault(rest, own or around)
            if name != first:
                what = f"the order of the names changes: {rest} is '{first}' in one message and '{name}' in another"
                right = f"the name instead of the index, as in {rest.split('[')[0]}[name]"
                raise InputError(what, where=where, right=right)


@final
@dataclass(frozen=True, eq=False)
class Channel:
    """One publisher of a topic.

    Attributes:
        topic: its topic.
        decode: of its messages; None: they are not read.
        missing: paths after the topic of columns that no message has had yet.
        groups: the columns that messages have, by the steps before their last one.
        samples: of each column, by its path.
        why_not: why its messages cannot be read; empty: they can, or nobody asked for them.
    """

    topic: str
    decode: Decode | None
    missing: dict[str, None]
    groups: dict[tuple[Step, ...], _Group] = field(default_factory=dict)
    samples: dict[str, Samples] = field(default_factory=dict)
    why_not: list[str] = field(default_factory=list)

    @property
    def has_columns(self) -> bool:
        """Whether anything of it was asked for."""
        return bool(self.missing or self.groups)

    @property
    def n_columns(self) -> int:
        """How many columns were asked for."""
        return len(self.missing) + sum(len(group.members) for group in self.groups.values())

    def values_in(self, message: Any) -> dict[str, Any]:
        """What each column's path leads to in a message, number or not."""
        values: dict[str, Any] = {}
        for group in self.groups.values():
            for rest, step in group.members.items():
                path = walked(message, (*group.prefix, step))
                values |= {} if path is None else {rest: path[-1]}
        return values

    def expect(self, rest: str) -> None:
        """Ask for one more column."""
        if not any(rest in group.members for group in self.groups.values()):
            self.missing[rest] = None

    def samples_in(self, message: Any, where: str) -> Iterator[tuple[str, float]]:
        """The path and the number of each column that a message has a sample of.

        Raises:
            InputError: an index leads to a value of another name than before.
        """
        for rest in list(self.missing):
            steps = path_in(message, rest)
            if steps == () and (number := message_number(message)) is not None:  # the message itself is one
                yield rest, number
            elif steps:
                del self.missing[rest]
                self.groups.setdefault(steps[:-1], _Group(steps[:-1])).add(rest, steps[-1])
        for group in self.groups.values():
            yield from group.samples_in(message, where)
