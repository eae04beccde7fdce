"""Read MCAP logs (format: https://mcap.dev/spec); chunks are unpacked one at a time, each up to a size limit."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import IO, Any

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers import mcap_chunks
from estexp_jax.recordings.readers.decoding import decoder_of
from estexp_jax.recordings.readers.topics import TopicMerger
from estexp_jax.recordings.table import Selection, Table

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
            wanted: dict[int, bool] = {}
            for schema, channel, message in _messages(stream, path, notes):
                if channel.id not in wanted:
                    decode = partial(decoder_of, channel.message_encoding, schema)
                    wanted[channel.id] = merger.open((number, channel.id), channel.topic, decode)
                    if wanted[channel.id]:
                        definitions.setdefault(channel.topic, set()).add(schema.data if schema else b"")
                if wanted[channel.id]:
                    merger.add((number, channel.id), message.data, message.log_time, message.publish_time)
    for topic in sorted(topic for topic, texts in definitions.items() if len(texts) > 1):
        notes.append(f"topic {topic} has channels with different definitions; each is read by its own")
    return merger.table(notes)


def _messages(stream: IO[bytes], path: Path, notes: list[str]) -> Iterator[tuple[Any, Any, Any]]:
    """Schema, channel and message of each message record, in order of the file."""
    from mcap.exceptions import EndOfFile
    from mcap.records import Channel, Message, Schema

    schemas: dict[int, Any] = {}
    channels: dict[int, Any] = {}
    n_messages = 0
    try:
        for record in mcap_chunks.records(stream):
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
        notes.append(_ENDED)
    except (InputError, GeneratorExit):
        raise
    except Exception as error:  # a parser may raise anything on damaged bytes
        reason = " ".join(f"{error or type(error).__name__}".split())[:200]
        raise InputError(f"is not an MCAP file, or is damaged: {reason}", where=str(path)) from None
