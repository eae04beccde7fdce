"""Read MCAP logs (format: https://mcap.dev/spec); chunks are unpacked one at a time, each up to a size limit."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import IO, Any

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers import mcap_chunks
from estexp_jax.recordings.readers.decoding import MOST_DEFINITION_BYTES, decoder_of
from estexp_jax.recordings.readers.topics import TopicMerger
from estexp_jax.recordings.table import Selection, Table

_MOST_DEFINITIONS = 4
"""So many times the longest definition all definitions together may be."""
_ENDED = "the file ends in the middle, as if its logger had died; read as far as it goes"


def read_mcap(path: Path, selection: Selection) -> Table:
    """Read the requested topics of JSON, ROS 2 and protobuf messages; times are in s from the first row on.

    Raises:
        InputError: the file is not MCAP, damaged or too large, or the extra `mcap` is not installed.
    """
    return read_mcaps([path], str(path), selection)


def read_mcaps(paths: Sequence[Path], source: str, selection: Selection) -> Table:
    """Read MCAP files that a recorder split as one log; those called `.zstd` are unpacked as they are read.

    Args:
        paths: at least one, in their order.
        source: the log, for messages.
        selection: which columns, by which clock.

    Raises: as `read_mcap`.
    """
    try:
        import mcap  # noqa: F401
        import mcap_ros2  # noqa: F401
    except ImportError:
        right = "pip install 'estexp_jax[mcap]'"
        raise InputError("is MCAP, which needs the extra `mcap`", where=source, right=right) from None
    merger, notes = TopicMerger(source, selection), list[str]()
    definitions: dict[str, set[bytes]] = {}
    for number, path in enumerate(paths):
        with mcap_chunks.opened(path) as stream:
            wanted, unwanted = set[int](), set[int]()
            for schema, channel, message in _messages(stream, path, notes, unwanted):
                if channel.id not in wanted:
                    decode = partial(decoder_of, channel.message_encoding, schema)
                    if not merger.open((number, channel.id), channel.topic, decode):
                        unwanted.add(channel.id)
                        continue
                    wanted.add(channel.id)
                    definitions.setdefault(channel.topic, set()).add(schema.data if schema else b"")
                    _check_sum(definitions, source)
                merger.add((number, channel.id), message.data, message.log_time, message.publish_time)
    for topic in sorted(topic for topic, texts in definitions.items() if len(texts) > 1):
        notes.append(f"topic {topic} has channels with different definitions; each is read by its own")
    return merger.table(notes)


def _check_sum(definitions: Mapping[str, Collection[bytes]], source: str) -> None:
    """See that not each of very many topics has a long definition of its own."""
    length = sum(map(len, {text for texts in definitions.values() for text in texts}))
    if length > _MOST_DEFINITIONS * MOST_DEFINITION_BYTES:
        right = f"at most {_MOST_DEFINITIONS * MOST_DEFINITION_BYTES:,}; name the columns in a manifest"
        raise InputError(f"the definitions of its messages have {length:,} bytes", where=source, right=right)


def _messages(
    stream: IO[bytes], path: Path, notes: list[str], unwanted: Collection[int]
) -> Iterator[tuple[Any, Any, mcap_chunks.RawMessage]]:
    """Schema, channel and message of each message record, in order of the file, but for unwanted channels."""
    from mcap.exceptions import EndOfFile
    from mcap.records import Channel, Schema

    schemas: dict[int, Any] = {}
    channels: dict[int, Any] = {}
    n_messages = 0
    try:
        for record in mcap_chunks.records(stream, unwanted):
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, mcap_chunks.RawMessage):
                n_messages += 1
                yield schemas.get(channels[record.channel_id].schema_id), channels[record.channel_id], record
    except EndOfFile:
        if not n_messages:
            raise InputError("is not an MCAP file, or ends before any message", where=str(path)) from None
        notes.append(_ENDED)
    except (InputError, GeneratorExit):
        raise
    except Exception as error:  # a parser may raise anything on damaged bytes
        reason = " ".join(f"{error or type(error).__name__}".split())[:200]
        raise InputError(f"is not an MCAP file, or is damaged: {reason}", where=str(path)) from None
