"""Read MCAP logs: messages of several topics, each with its own clock, merged into one table.

Each row is a time at which a requested topic has a message. The columns of topics without a message at that time are
empty, which means no sample, or the last command. Chunks are unpacked one at a time, each up to a size limit
(format: https://mcap.dev/spec).
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO, Any, final

import numpy as np

from estexp_jax.errors import InputError, listing
from estexp_jax.recordings.readers.messages import (
    Step,
    decoder_of,
    follow,
    message_number,
    nanoseconds,
    numbers_in,
    path_in,
)
from estexp_jax.recordings.table import MOST_COLUMNS, Selection, Table, check_size

MOST_CHUNK_BYTES = 2**28
"""Size limit of a record or unpacked chunk; usual chunks have a few MB."""
_MOST_MESSAGES = 50_000_000


def _times() -> array:
    return array("q")


def _values() -> array:
    return array("d")


@final
@dataclass(frozen=True, eq=False)
class _Column:
    """Samples of one path in order of the file: time in ns and value.

    `ways` holds the steps to the value, once a message contained it.
    """

    times: array = field(default_factory=_times)
    values: array = field(default_factory=_values)
    ways: list[tuple[Step, ...]] = field(default_factory=list)


@final
@dataclass(frozen=True, eq=False)
class _Topic:
    """Columns of one topic by their path after the topic, or the reason why it is not read."""

    decode: Callable[[bytes], Any] | None
    columns: dict[str, _Column]
    why_not: str = ""


def read_mcap(path: Path, selection: Selection) -> Table:
    """Read the requested topics of JSON and ROS 2 messages; times are in s from the first row on.

    Raises:
        InputError: the file is not MCAP, damaged or too large, or the extra `mcap` is not installed.
    """
    try:
        import mcap  # noqa: F401
        import mcap_ros2  # noqa: F401
    except ImportError:
        right = "pip install 'estexp_jax[mcap]'"
        raise InputError("is MCAP, which needs the extra `mcap`", where=str(path), right=right) from None
    topics: dict[str, _Topic] = {}
    notes: list[str] = []
    with path.open("rb") as stream:
        for count, (schema, channel, message) in enumerate(_messages(stream, path, notes)):
            if count >= _MOST_MESSAGES:
                raise InputError(f"has more than {_MOST_MESSAGES:,} messages", where=str(path), right="a shorter log")
            if channel.topic not in topics:
                topics[channel.topic] = _topic(schema, channel, selection)
            topic = topics[channel.topic]
            if topic.decode is not None:
                _add_message(topic.decode, topic.columns, message, selection, f"{path}, topic '{channel.topic}'")
    return _table(path, topics, selection, notes)


def _messages(stream: IO[bytes], path: Path, notes: list[str]) -> Iterator[tuple[Any, Any, Any]]:
    """Schema, channel and message of each message record, in order of the file."""
    from mcap.exceptions import EndOfFile
    from mcap.records import Channel, Message, Schema

    schemas: dict[int, Any] = {}
    channels: dict[int, Any] = {}
    n_messages = 0
    try:
        for record in _records(stream):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Message):
                n_messages += 1
                yield schemas.get(channels[record.channel_id].schema_id), channels[record.channel_id], record
    except EndOfFile:
        if not n_messages:
            raise InputError("is not an MCAP file, or ends before any message", where=str(path)) from None
        notes.append("the file ends in the middle, as if its logger had died; read as far as it goes")
    except (InputError, GeneratorExit):
        raise
    except Exception as error:  # a parser may raise anything on damaged bytes
        reason = " ".join(f"{error or type(error).__name__}".split())[:200]
        raise InputError(f"is not an MCAP file, or is damaged: {reason}", where=str(path)) from None


def _records(stream: IO[bytes]) -> Iterator[Any]:
    """All records, including those in chunks."""
    from mcap.records import Chunk
    from mcap.stream_reader import StreamReader, breakup_chunk

    for record in StreamReader(stream, emit_chunks=True, record_size_limit=MOST_CHUNK_BYTES).records:
        if not isinstance(record, Chunk):
            yield record
            continue
        record.data, record.compression = _decompress(record), ""
        yield from breakup_chunk(record, validate_crc=True)


def _decompress(chunk: Any) -> bytes:
    """A chunk's unpacked bytes; neither of the sizes that the file claims is trusted."""
    if not chunk.compression:
        return chunk.data
    if chunk.uncompressed_size > MOST_CHUNK_BYTES:
        raise ValueError(f"a chunk claims to unpack to {chunk.uncompressed_size:,} bytes")
    if chunk.compression == "zstd":
        import zstandard

        # As a stream, since decompress() allocates what the data's header claims.
        with zstandard.ZstdDecompressor(max_window_size=MOST_CHUNK_BYTES).stream_reader(chunk.data) as reader:
            data = reader.read(chunk.uncompressed_size + 1)
    elif chunk.compression == "lz4":
        from lz4.frame import LZ4FrameDecompressor

        data = LZ4FrameDecompressor().decompress(chunk.data, max_length=chunk.uncompressed_size + 1)
    else:
        raise ValueError(f"a chunk is compressed with '{chunk.compression[:80]}'; zstd and lz4 are read")
    if len(data) != chunk.uncompressed_size:
        raise ValueError(f"a chunk does not unpack to the {chunk.uncompressed_size:,} bytes that it claims")
    return data


def _topic(schema: Any, channel: Any, selection: Selection) -> _Topic:
    """The columns to read from a topic, decided at its first message."""
    name, requested = channel.topic, selection.wanted
    columns = {p[len(name) :]: _Column() for p in requested or () if p.startswith(name) and p[len(name) :][:1] in "[."}
    if requested is not None and not columns:
        return _Topic(None, {})
    try:
        return _Topic(decoder_of(channel.message_encoding, schema), columns)
    except Exception as error:  # a definition that cannot be parsed may raise anything
        return _Topic(None, columns, " ".join(f"{error or type(error).__name__}".split())[:200])


def _add_message(
    decode: Callable[[bytes], Any], columns: dict[str, _Column], record: Any, selection: Selection, where: str
) -> None:
    """Add a message's samples to its topic's columns."""
    try:
        message = decode(record.data)
        for rest in numbers_in(message) if selection.wanted is None else ():
            if len(columns) < MOST_COLUMNS:
                columns.setdefault(rest, _Column())
    except Exception as error:  # a decoder may raise anything on damaged bytes
        reason = " ".join(f"{error or type(error).__name__}".split())[:200]
        raise InputError(f"a message cannot be decoded: {reason}", where=where) from None
    time = _time(record, message, selection.clock)
    if time is None or not -(2**62) < time < 2**62:
        right = 'a stamp in each message\'s header; else clock = "log"'
        raise InputError(f"a message has no time on the clock '{selection.clock}'", where=where, right=right)
    for rest, column in columns.items():
        if not column.ways and (way := path_in(message, rest)) is not None:
            column.ways.append(way)
        value = message_number(follow(message, column.ways[0])) if column.ways else None
        if value is not None:
            column.times.append(time)
            column.values.append(value)


def _time(record: Any, message: Any, clock: str) -> int | None:
    if clock == "header":
        return nanoseconds(follow(message, ("header", "stamp")))
    return record.log_time if clock == "log" else record.publish_time


def _table(path: Path, topics: dict[str, _Topic], selection: Selection, notes: list[str]) -> Table:
    columns = {f"{name}{rest}": c for name, topic in topics.items() for rest, c in topic.columns.items() if c.times}
    times = [np.frombuffer(column.times, dtype=np.int64) for column in columns.values()]
    every = np.unique(np.concatenate(times)) if times else np.empty(0, dtype=np.int64)
    check_size(len(every) * len(columns), str(path))
    filled: dict[str, np.ndarray] = {"time": 1e-9 * (every - every[:1])}
    for (name, column), stamps in zip(columns.items(), times, strict=True):
        filled[name] = np.full(len(every), np.nan)
        filled[name][np.searchsorted(every, stamps)] = column.values
    n_repeated = max((len(stamps) - len(np.unique(stamps)) for stamps in times), default=0)
    if n_repeated:
        notes.append(f"{n_repeated} messages have the time of another one of their topic; the last of each time counts")
    unread = [name for name, topic in topics.items() if not topic.columns and not topic.why_not]
    if unread and selection.wanted is not None:
        notes.append(f"topics that were not asked for: {listing(unread)}")
    unusable = _missing_columns(path, topics, columns, selection)
    if unusable and not columns:
        raise next(iter(unusable.values()))
    return Table(str(path), filled, unusable, notes=tuple(notes))


def _missing_columns(
    path: Path, topics: dict[str, _Topic], columns: dict[str, Any], selection: Selection
) -> dict[str, Any]:
    """Errors for requested columns that do not exist, and for topics that cannot be read."""
    errors: dict[str, InputError] = {}
    for name in sorted((selection.wanted or frozenset()) - set(columns) - {"time"}):
        topic = next((t for t in topics if name.startswith(t) and topics[t].columns), None)
        if topic is None:
            right = f"a path such as /joint_states.position[0]; topics are: {listing(topics) or 'none'}"
            errors[name] = InputError(f"no topic for '{name}'", where=str(path), right=right)
        else:
            what = topics[topic].why_not or "no message has a number there"
            errors[name] = InputError(what, where=f"{path}, '{name}'", right="see what the topic holds with --init")
    if selection.wanted is None:
        why = {name: topic.why_not for name, topic in topics.items() if topic.why_not}
        errors |= {name: InputError(text, where=f"{path}, topic '{name}'") for name, text in why.items()}
    return errors
