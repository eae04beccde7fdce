"""Where the numbers of a ROS 2 message lie in its bytes (CDR, version 1), without decoding them.

Numbers are aligned to their size, counted from the end of the mark of four bytes; texts and lists begin with their
length. So two messages of equal texts and equal lengths of lists have their numbers in the same places.
Source: section 7.4.1 of DDS-XTypes 1.3 (https://www.omg.org/spec/DDS-XTYPES/1.3).
"""

from __future__ import annotations

import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, final, overload

CODES: Mapping[str, str] = {
    "bool": "?",
    "byte": "B",
    "char": "b",
    "float32": "f",
    "float64": "d",
    "int8": "b",
    "uint8": "B",
    "int16": "h",
    "uint16": "H",
    "int32": "i",
    "uint32": "I",
    "int64": "q",
    "uint64": "Q",
}
"""Types of numbers in message definitions, each with its letter in `struct`."""
MOST_PARTS = 200_000
"""Limit of texts and messages in one message; numbers in a list count as one part."""
_MARK_BYTES = 4


@final
@dataclass(frozen=True)
class Place:
    """Where a number lies: offset in the message's bytes, and its letter in `struct`."""

    offset: int
    code: str


@final
@dataclass(frozen=True)
class Places(Sequence[Place]):
    """Where the numbers of a list lie, one behind the other."""

    offset: int
    code: str
    length: int

    def __len__(self) -> int:
        return self.length

    @overload
    def __getitem__(self, index: int) -> Place: ...
    @overload
    def __getitem__(self, index: slice) -> list[Place]: ...
    def __getitem__(self, index: int | slice) -> Place | list[Place]:
        found = range(self.length)[index]
        if isinstance(found, range):
            return [self[k] for k in found]
        return Place(self.offset + found * struct.calcsize(f"<{self.code}"), self.code)


@final
@dataclass(frozen=True, eq=False)
class Located:
    """A message with places instead of numbers.

    Attributes:
        message: its fields, nested as in the message; texts as they are.
        fixed: first byte and end of each part that decides about the places: the mark, lengths, texts.
        order: `<` or `>`, of the bytes.
    """

    message: Mapping[str, Any]
    fixed: tuple[tuple[int, int], ...]
    order: str


def locate(data: bytes, definition: Any, definitions: Mapping[str, Any]) -> Located:
    """Where the numbers of a message lie.

    Args:
        data: of the message, with its mark.
        definition: of its kind, as the parser of `rosidl` gives it.
        definitions: of the kinds in it, by `package/name`.

    Raises:
        ValueError: the message is shorter than its definition says, has more than `MOST_PARTS` parts, or the
            definition has a type that is not known.
        KeyError: a definition is missing.
    """
    cursor = _Cursor(data, "<" if data[1] & 1 else ">")
    message = _struct(cursor, definition, definitions)
    return Located(message, tuple(cursor.fixed), cursor.order)


@final
@dataclass
class _Cursor:
    data: bytes
    order: str
    at: int = _MARK_BYTES
    fixed: list[tuple[int, int]] = field(default_factory=lambda: [(0, _MARK_BYTES)])
    n_parts: int = 0

    def take(self, code: str, count: int = 1) -> int:
        """Go over numbers; where the first one lies."""
        size = struct.calcsize(f"<{code}")
        first = self.at + (_MARK_BYTES - self.at) % size if count else self.at
        self.at = first + size * count
        if self.at > len(self.data):
            raise ValueError("the message ends early")
        return first

    def count_part(self) -> None:
        """One more text or message in the message."""
        self.n_parts += 1
        if self.n_parts > MOST_PARTS:
            raise ValueError(f"a message has more than {MOST_PARTS:,} parts")

    def length(self) -> int:
        """Read a length."""
        first = self.take("I")
        self._fix(first)
        return int(struct.unpack_from(f"{self.order}I", self.data, first)[0])

    def text(self) -> str:
        """Read a text."""
        self.count_part()
        length = self.length()
        first = self.take("B", length)
        self._fix(first)
        return self.data[first : first + max(length - 1, 0)].decode()

    def _fix(self, first: int) -> None:
        start, end = self.fixed[-1]
        if first == end:  # not across padding, whose bytes may be any
            self.fixed[-1] = (start, self.at)
        else:
            self.fixed.append((first, self.at))


def _struct(cursor: _Cursor, definition: Any, definitions: Mapping[str, Any]) -> dict[str, Any]:
    cursor.count_part()
    if not definition.fields:
        cursor.take("B")  # of which an empty message consists
    return {each.name: _field(cursor, each.type, definitions) for each in definition.fields}


def _field(cursor: _Cursor, kind: Any, definitions: Mapping[str, Any]) -> Any:
    if not kind.is_array:
        return _value(cursor, kind, definitions)
    count = kind.array_size if kind.is_fixed_size_array() else cursor.length()
    if kind.is_primitive_type() and kind.type in CODES:
        return Places(cursor.take(CODES[kind.type], count), CODES[kind.type], count)
    return [_value(cursor, kind, definitions) for _ in range(count)]


def _value(cursor: _Cursor, kind: Any, definitions: Mapping[str, Any]) -> Any:
    if not kind.is_primitive_type():
        return _struct(cursor, definitions[f"{kind.pkg_name}/{kind.type}"], definitions)
    if kind.type == "string":
        return cursor.text()
    if kind.type not in CODES:
        raise ValueError(f"{kind.type} is not known")
    return Place(cursor.take(CODES[kind.type]), CODES[kind.type])
