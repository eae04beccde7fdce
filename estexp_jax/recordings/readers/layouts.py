"""Read what is asked for straight from a message's bytes, where messages of the same shape came before.

The first message of a shape is decoded in full. From it, the places of the numbers asked for are known, and hold for
all messages whose texts and lengths of lists are the same ones. Others are decoded in full.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, final

from estexp_jax.recordings.readers.cdr import Located, Place
from estexp_jax.recordings.readers.channels import Channel, Samples
from estexp_jax.recordings.readers.messages import follow

Stamps = Sequence[Sequence[str]]
"""Paths at which a message may have its own time."""
_MOST_SHAPES, _MOST_ALIKE = 64, 8
"""How many shapes of a channel's messages are remembered, and how many of one size."""
_LAST_NS = 2**62
_CLOCKS = ("log", "publish", "header")


@final
@dataclass(frozen=True, eq=False)
class _Layout:
    """Of messages of one shape.

    Attributes:
        fixed: the parts that decide about the shape.
        texts: their bytes.
        selected: the numbers asked for, in the order of their places.
        columns: each column with the index of its clock's time and of its number.
        stamp: indices of a message's own seconds and nanoseconds in `selected`; None: it is not asked for.
    """

    fixed: struct.Struct
    texts: tuple[bytes, ...]
    selected: struct.Struct
    columns: tuple[tuple[Samples, int, int], ...]
    stamp: tuple[int, int] | None

    def add(self, data: bytes, log_ns: int, publish_ns: int) -> bool:
        """Keep a message's samples, if it has this shape and its times are possible; whether it has."""
        if self.fixed.unpack_from(data) != self.texts:
            return False
        selected = self.selected.unpack_from(data)
        stamp = 0 if self.stamp is None else selected[self.stamp[0]] * 1_000_000_000 + selected[self.stamp[1]]
        if log_ns >= _LAST_NS or publish_ns >= _LAST_NS or not -_LAST_NS < stamp < _LAST_NS:
            return False
        times = (log_ns, publish_ns, stamp)
        for samples, clock, number in self.columns:
            samples.times.append(times[clock])
            samples.values.append(selected[number])
        return True


@final
@dataclass(eq=False)
class Layouts:
    """The shapes of one channel's messages.

    Attributes:
        channel: its columns.
        locate: finds the places of a message's numbers; may raise ValueError or KeyError.
        by_size: the layouts of messages of each size, in bytes.
        n_columns: how many columns the channel had when they were made.
        n_tried: of how many messages the layout was looked for.
    """

    channel: Channel
    locate: Callable[[bytes], Located]
    by_size: dict[int, list[_Layout]] = field(default_factory=dict)
    n_columns: int = 0
    n_tried: int = 0

    def add(self, data: bytes, log_ns: int, publish_ns: int) -> bool:
        """Keep a message's samples, if its shape is known; whether it is."""
        layouts = self.by_size.get(len(data), ())
        return any(layout.add(data, log_ns, publish_ns) for layout in layouts)

    def learn(self, data: bytes, found: Mapping[str, float], stamp: int | None, stamps: Stamps) -> None:
        """Remember the shape of a message that was decoded in full, where that is possible.

        Args:
            data: of the message.
            found: its samples, by the path of the column.
            stamp: its own time, ns; None if it has none.
            stamps: where that may be.
        """
        if self.n_columns != self.channel.n_columns:  # a column more may be in messages of shapes known before
            self.by_size.clear()
            self.n_columns = self.channel.n_columns
        alike = self.by_size.setdefault(len(data), [])
        if self.n_tried >= _MOST_SHAPES or len(alike) >= _MOST_ALIKE:
            return
        self.n_tried += 1
        try:
            layout = self._layout(data, found, stamp, stamps)
        except (ValueError, KeyError, UnicodeDecodeError):
            return
        if layout is not None:
            alike.append(layout)

    def _layout(self, data: bytes, found: Mapping[str, float], stamp: int | None, stamps: Stamps) -> _Layout | None:
        """The layout of a message; None where its samples are not numbers of its own, or are read otherwise."""
        located = self.locate(data)
        values = self.channel.values_in(located.message)
        wanted = {rest: place for rest in found if isinstance(place := values.get(rest), Place)}
        own = _stamp_places(located.message, stamps) if self._reads_stamps(found) else ()
        if own is None or len(wanted) < len(found):
            return None
        ordered = sorted({*wanted.values(), *own}, key=_offset)
        selected = _struct(located.order, ((p.offset, struct.calcsize(f"<{p.code}"), p.code) for p in ordered))
        fixed = _struct("<", ((start, end - start, f"{end - start}s") for start, end in located.fixed))
        index = {place: k for k, place in enumerate(ordered)}
        columns = []
        for rest, place in wanted.items():
            samples = self.channel.samples[rest]
            columns.append((samples, _CLOCKS.index(samples.clock), index[place]))
        pair = (index[own[0]], index[own[1]]) if own else None
        layout = _Layout(fixed, fixed.unpack_from(data), selected, tuple(columns), pair)
        return layout if _agrees(layout, data, found.values(), stamp) else None

    def _reads_stamps(self, found: Iterable[str]) -> bool:
        return any(self.channel.samples[rest].clock == "header" for rest in found)


def _agrees(layout: _Layout, data: bytes, values: Iterable[float], stamp: int | None) -> bool:
    """Whether a layout reads from a message what decoding it in full gave."""
    selected = layout.selected.unpack_from(data)
    read = [float(selected[index]) for _, _, index in layout.columns]
    same = all(a == b or (a != a and b != b) for a, b in zip(read, values, strict=True))
    if layout.stamp is None:
        return same
    return same and stamp == selected[layout.stamp[0]] * 1_000_000_000 + selected[layout.stamp[1]]


def _offset(place: Place) -> int:
    return place.offset


def _struct(order: str, parts: Iterable[tuple[int, int, str]]) -> struct.Struct:
    """What reads parts of given offset, size and letters, in order, and goes over what lies between."""
    at, text = 0, order
    for offset, size, code in parts:
        text += f"{offset - at}x{code}"
        at = offset + size
    return struct.Struct(text)


def _stamp_places(message: Mapping[str, Any], stamps: Stamps) -> tuple[Place, Place] | None:
    """Where a message's own seconds and nanoseconds lie; None if it has none of this form."""
    for path in stamps:
        found = follow(message, tuple(path))
        if isinstance(found, Mapping):
            first, second = found.get("sec"), found.get("nanosec")
            if isinstance(first, Place) and isinstance(second, Place) and {first.code, second.code} <= set("iIqQ"):
                return first, second
    return None
