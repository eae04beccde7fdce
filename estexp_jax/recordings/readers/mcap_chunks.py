"""The records of an MCAP file, also of one that ends in the middle of a record or is compressed as a whole."""

from __future__ import annotations

import struct
from collections.abc import Collection, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from io import BytesIO
from pathlib import Path
from typing import IO, Any, cast, final
from zlib import crc32

MOST_CHUNK_BYTES = 2**28
"""Size limit of a record or unpacked chunk; usual chunks have a few MB."""
_MOST_TIMES, _FEW_BYTES = 1000, 2**26
_CHUNK = 6
_RECORD, _MESSAGE = struct.Struct("<BQ"), struct.Struct("<H4xQQ")
"""The beginnings of a record (kind, length) and of a message (channel, times) in it: https://mcap.dev/spec."""


@contextmanager
def opened(path: Path) -> Iterator[IO[bytes]]:
    """An MCAP file's bytes; those of a file compressed as a whole (`.mcap.zstd`, rosbag2's file mode) unpacked."""
    with path.open("rb") as file:
        if path.suffix.lower() not in (".zstd", ".zst"):
            yield cast(IO[bytes], _Stream(file))
            return
        import zstandard

        unpacker = zstandard.ZstdDecompressor(max_window_size=MOST_CHUNK_BYTES)
        with unpacker.stream_reader(file, read_across_frames=True) as unpacked:
            yield cast(IO[bytes], _Stream(unpacked, most=max(_FEW_BYTES, _MOST_TIMES * path.stat().st_size)))


@final
@dataclass
class _Stream:
    """A stream that ends where its last whole piece ends; `left` is the beginning of a piece that was cut.

    Attributes:
        stream: what is read.
        most: how many bytes it may have.
        count: how many were read.
        last: the pieces of the record under way, as they were asked for.
    """

    stream: Any
    most: float = float("inf")
    count: int = 0
    pieces: list[bytes] = field(default_factory=list)

    def read(self, length: int) -> bytes:
        """As many bytes as asked for.

        Raises:
            EndOfFile: there are fewer.
            ValueError: the file unpacks to far more than any log.
        """
        from mcap.exceptions import EndOfFile

        data = b""
        while len(data) < length:
            more = self.stream.read(length - len(data))
            if not more:
                break
            data = data + more if data else more
        self.count += len(data)
        self.pieces.append(data)
        if self.count > self.most:
            raise ValueError(f"it unpacks to more than {_MOST_TIMES} times its size")
        if len(data) < length:
            raise EndOfFile
        return data


@final
@dataclass(frozen=True, slots=True)
class RawMessage:
    """A message record: its channel, times in ns, and bytes."""

    channel_id: int
    log_time: int
    publish_time: int
    data: bytes


def records(stream: Any, unwanted: Collection[int] = ()) -> Iterator[Any]:
    """All records of an opened file, including those in chunks; messages as `RawMessage`.

    Args:
        stream: as `opened` gives it.
        unwanted: channels whose messages may be left out; it may grow meanwhile.

    Raises:
        EndOfFile: after the last record of a file that has no end; what is whole in its last chunk comes before.
        Exception: of the parser, on damaged bytes.
    """
    from mcap.exceptions import EndOfFile
    from mcap.records import Chunk, Message
    from mcap.stream_reader import CRCValidationError, StreamReader

    try:
        for record in StreamReader(stream, emit_chunks=True, record_size_limit=MOST_CHUNK_BYTES).records:
            stream.pieces.clear()
            if isinstance(record, Message):
                yield RawMessage(record.channel_id, record.log_time, record.publish_time, record.data)
            elif isinstance(record, Chunk):
                data = _decompress(record)
                if record.uncompressed_crc and crc32(data) != record.uncompressed_crc:
                    raise CRCValidationError(record.uncompressed_crc, crc32(data), record)
                at = yield from _whole_records(data, unwanted)
                if at != len(data):
                    raise ValueError("a record of a chunk is longer than the chunk")
            else:
                yield record
    except EndOfFile:
        yield from _whole_records(_beginning_of_chunk(b"".join(stream.pieces)), unwanted)
        raise


def _whole_records(data: bytes, unwanted: Collection[int]) -> Generator[Any, None, int]:
    """The schemas, channels and messages that are whole in a chunk's bytes; returns where the last one ends."""
    from mcap.data_stream import ReadDataStream
    from mcap.opcode import Opcode
    from mcap.records import Channel, Schema

    kinds = {int(Opcode.SCHEMA): Schema, int(Opcode.CHANNEL): Channel}
    message, at = int(Opcode.MESSAGE), 0
    while at + _RECORD.size <= len(data):
        kind, length = _RECORD.unpack_from(data, at)
        first, end = at + _RECORD.size, at + _RECORD.size + length
        if end > len(data):
            break
        if kind == message:
            if length < _MESSAGE.size:
                raise ValueError(f"a message record has {length} bytes")
            channel_id, log_time, publish_time = _MESSAGE.unpack_from(data, first)
            if channel_id not in unwanted:
                yield RawMessage(channel_id, log_time, publish_time, data[first + _MESSAGE.size : end])
        elif kind in kinds:
            yield kinds[kind].read(ReadDataStream(BytesIO(data[first:end])))
        at = end
    return at


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


def _beginning_of_chunk(record: bytes) -> bytes:
    """The unpacked beginning of a chunk's records, from the record's own beginning; empty if it is no chunk."""
    if record[:1] != bytes([_CHUNK]) or len(record) < 41:
        return b""
    size = min(struct.unpack_from("<Q", record, 25)[0], MOST_CHUNK_BYTES)
    length = struct.unpack_from("<I", record, 37)[0]
    compression, data = record[41 : 41 + length], record[41 + length + 8 :]
    if compression == b"zstd":
        import zstandard

        with zstandard.ZstdDecompressor(max_window_size=MOST_CHUNK_BYTES).stream_reader(data) as reader:
            return _all_there_is(reader, size)
    if compression == b"lz4":
        from lz4.frame import LZ4FrameDecompressor

        return LZ4FrameDecompressor().decompress(data, max_length=size) if data else b""
    return data if not compression else b""


def _all_there_is(reader: Any, most: int) -> bytes:
    pieces, left = [], most
    while left > 0 and (piece := reader.read(min(left, 2**16))):
        pieces.append(piece)
        left -= len(piece)
    return b"".join(pieces)
