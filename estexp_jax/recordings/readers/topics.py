"""Messages of several topics, each with a clock of its own, merged into one table.

Each row is a time at which a requested topic has a message. The columns of topics without a message at that time are
empty, which means no sample, or the last command.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Hashable, Mapping
from typing import Any, final

import numpy as np

from estexp_jax.errors import InputError, listing
from estexp_jax.recordings.readers.channels import Channel, Decode, Samples
from estexp_jax.recordings.readers.decoding import CdrDecoder
from estexp_jax.recordings.readers.layouts import Layouts
from estexp_jax.recordings.readers.messages import follow, nanoseconds, numbers_in
from estexp_jax.recordings.readers.name_lists import NameLists
from estexp_jax.recordings.table import MOST_COLUMNS, Selection, Table, check_size

_MOST_MESSAGES = 50_000_000
_UNSET_NS = 1_000_000_000
"""A stamp of 0 was never set if all others are later than this; else the clock begins there."""
_STAMPS = (("header", "stamp"), ("timestamp",))  # of ROS, of Foxglove

_OTHER_CLOCK = {"log": "header", "publish": "log", "header": "log"}
"""Which clock to try where one does not serve."""


@final
class TopicMerger:
    """Takes messages one by one, keeps the samples asked for, and merges them into a table."""

    def __init__(self, source: str, selection: Selection) -> None:
        """Nothing is merged yet.

        Args:
            source: the log, for messages.
            selection: which columns are wanted, and by which clocks.
        """
        self._source, self._selection = source, selection
        self._channels: dict[Hashable, Channel] = {}
        self._layouts: dict[Hashable, Layouts] = {}
        self._samples: dict[str, Samples] = {}
        self._name_lists = NameLists()
        self._n_messages = 0

    def open(self, key: Hashable, topic: str, make: Callable[[], Decode]) -> bool:
        """Make a channel known, once; whether its messages are wanted.

        Args:
            key: of the channel; two channels may have one topic.
            topic: its topic.
            make: makes the decoder of its messages; may raise anything if it cannot.
        """
        if key not in self._channels:
            wanted = self._selection.wanted
            rests = [p[len(topic) :] for p in wanted or () if p.startswith(topic) and p[len(topic) :][:1] in ("[", ".")]
            channel = Channel(topic, None, dict.fromkeys(rests))
            if wanted is None or rests:
                try:
                    channel = Channel(topic, make(), dict.fromkeys(rests))
                except Exception as error:  # a definition that cannot be parsed may raise anything
                    channel.why_not.append(_reason(error))
            self._channels[key] = channel
            if isinstance(channel.decode, CdrDecoder):
                self._layouts[key] = Layouts(channel, channel.decode.locate)
        return self._channels[key].decode is not None and not self._channels[key].why_not

    def add(self, key: Hashable, data: Any, log_ns: int, publish_ns: int) -> None:
        """Keep a message's samples.

        Raises:
            InputError: it cannot be decoded, has no time on its clock, or an index leads to another joint than before.
        """
        self._n_messages += 1
        if self._n_messages > _MOST_MESSAGES:
            raise InputError(f"has more than {_MOST_MESSAGES:,} messages", where=self._source, right="a shorter log")
        channel, layouts = self._channels[key], self._layouts.get(key)
        if channel.why_not or (layouts is not None and layouts.add(data, log_ns, publish_ns)):
            return
        where = f"{self._source}, topic '{channel.topic}'"
        try:
            message = channel.decode(data) if channel.decode else None
            for rest in numbers_in(message) if self._selection.wanted is None else ():
                if len(self._samples) < MOST_COLUMNS:
                    channel.expect(rest)
            if self._selection.wanted is None:
                self._name_lists.add(key, channel.topic, message)
        except Exception as error:  # a decoder may raise anything on damaged bytes
            what = f"a message cannot be decoded: {_reason(error)}"
            if self._selection.wanted is not None:
                raise InputError(what, where=where) from None
            channel.why_not.append(what)
            return
        times: dict[str, int | None] = {"log": log_ns, "publish": publish_ns}
        found = dict(channel.samples_in(message, where))
        for rest, value in found.items():
            samples = channel.samples.get(rest) or self._samples_of(channel, rest)
            if samples.clock not in times:
                times["header"] = _stamp(message)
            time = times[samples.clock]
            if time is None or not -(2**62) < time < 2**62:
                right = 'a stamp in each message\'s header; else clock = "log", for the file or for this column'
                raise InputError(f"a message has no time on the clock '{samples.clock}'", where=where, right=right)
            samples.times.append(time)
            samples.values.append(value)
        if layouts is not None:
            layouts.learn(data, found, times.get("header"), _STAMPS)

    def _samples_of(self, channel: Channel, rest: str) -> Samples:
        """The samples of a column, which all channels of its topic share."""
        name = f"{channel.topic}{rest}"
        clock = self._selection.clocks.get(name, self._selection.clock)
        channel.samples[rest] = self._samples.setdefault(name, Samples(clock))
        return channel.samples[rest]

    def table(self, notes: list[str]) -> Table:
        """All samples, with times in s from the first row on.

        Args:
            notes: remarks of the reader.

        Raises:
            InputError: no column can be read, or none of a column's messages has a stamp.
        """
        samples = {name: _stamped(name, each, self._source) for name, each in self._with_clock_set(notes).items()}
        every = np.unique(np.concatenate([t for t, _ in samples.values()])) if samples else np.empty(0, dtype=np.int64)
        check_size(len(every) * len(samples), self._source)
        filled: dict[str, np.ndarray] = {"time": 1e-9 * (every - every[:1])}
        for name, (stamps, values) in samples.items():
            filled[name] = np.full(len(every), np.nan)
            filled[name][np.searchsorted(every, stamps)] = values
        n_repeated = max((self._repeated(name, stamps) for name, (stamps, _) in samples.items()), default=0)
        if n_repeated:
            notes.append(
                f"{n_repeated} messages have the time of another one of their topic; the last of each time counts"
            )
        unread = [c.topic for c in self._channels.values() if not c.has_columns and not c.why_not]
        if unread and self._selection.wanted is not None:
            notes.append(f"topics that were not asked for: {listing(dict.fromkeys(unread))}")
        unusable = self._missing(samples)
        if unusable and not samples:
            raise next(iter(unusable.values()))
        labels = self._name_lists.labels(filled)
        return Table(self._source, filled, unusable, notes=tuple(notes), labels=labels)

    def _repeated(self, name: str, stamps: np.ndarray) -> int:
        """How many samples of a column have the time of another one of it.

        Raises:
            InputError: it was asked for, and most have.
        """
        n_times = len(np.unique(stamps))
        if self._selection.wanted is not None and 2 * n_times < len(stamps):
            clock = self._samples[name].clock
            right = (
                f'another clock, clock = "{_OTHER_CLOCK[clock]}", if that tells them apart; one topic for each joint'
            )
            what = f"{name}: {len(stamps)} messages have {n_times} different times on the clock '{clock}'"
            raise InputError(what, where=self._source, right=right)
        return len(stamps) - n_times

    def _with_clock_set(self, notes: list[str]) -> dict[str, Samples]:
        """The samples without those whose stamp was never set, which are told."""
        first = min((t for s in self._samples.values() for t in (_first_set(s.times),) if t is not None), default=None)
        if first is None or first <= _UNSET_NS:
            return self._samples
        kept: dict[str, Samples] = {}
        for name, each in self._samples.items():
            times, values = np.frombuffer(each.times, dtype=np.int64), np.frombuffer(each.values)
            unset = times == 0
            if unset.any():
                kept[name] = Samples(
                    each.clock, array("q", times[~unset].tobytes()), array("d", values[~unset].tobytes())
                )
                what = (
                    f"{name}: {int(unset.sum())} of {len(times)} messages have the stamp 0 on the clock '{each.clock}'"
                )
                if unset.all():
                    other = f'{{ column = "{name}", clock = "{_OTHER_CLOCK[each.clock]}" }}'
                    right = f"another clock for it: {other}, or for the whole file"
                    raise InputError(f"{what}: it was never set", where=self._source, right=right)
                notes.append(f"{what}: they are left out")
        return {**self._samples, **kept}

    def _missing(self, samples: Mapping[str, Any]) -> dict[str, InputError]:
        """Errors for requested columns that do not exist, and for topics that cannot be read."""
        errors: dict[str, InputError] = {}
        channels, wanted = self._channels.values(), self._selection.wanted
        for name in sorted((wanted or frozenset()) - set(samples) - {"time"}):
            asked = [c for c in channels if c.has_columns and name.startswith(c.topic)]
            if not asked:
                right = f"a path such as /joint_states.position[0]; topics are: {self._topics() or 'none'}"
                errors[name] = InputError(f"no topic for '{name}'", where=self._source, right=right)
            else:
                reasons = [reason for channel in asked for reason in channel.why_not]
                what = reasons[0] if reasons else "no message has a number there"
                right = "see what the topic holds with --init"
                errors[name] = InputError(what, where=f"{self._source}, '{name}'", right=right)
        if wanted is None:
            for channel in channels:
                for reason in channel.why_not[:1]:
                    errors[channel.topic] = InputError(reason, where=f"{self._source}, topic '{channel.topic}'")
        return errors

    def _topics(self) -> str:
        return listing(dict.fromkeys(channel.topic for channel in self._channels.values()))


def _stamp(message: Any) -> int | None:
    """The time in a message's header, ns; None if it has none."""
    return next((t for path in _STAMPS if (t := nanoseconds(follow(message, path))) is not None), None)


def _first_set(times: array) -> int | None:
    stamps = np.frombuffer(times, dtype=np.int64)
    stamps = stamps[stamps != 0]
    return int(stamps.min()) if len(stamps) else None


def _stamped(name: str, samples: Samples, source: str) -> tuple[np.ndarray, np.ndarray]:
    times = np.frombuffer(samples.times, dtype=np.int64)
    if len(times) > 2 and not times.any():
        right = f'another clock: clock = "{_OTHER_CLOCK[samples.clock]}"'
        raise InputError(f"{name}: all stamps are 0 on the clock '{samples.clock}'", where=source, right=right)
    return times, np.frombuffer(samples.values)


def _reason(error: Exception) -> str:
    return " ".join(f"{error or type(error).__name__}".split())[:300]
