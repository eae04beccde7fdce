"""Decode the messages of robot logs; what is encoded in another way than is read here is refused by its name."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import cached_property
from io import StringIO
from typing import Any, final

from estexp_jax.recordings.readers.cdr import Located, locate

MOST_MESSAGE_BYTES = 2**26
"""Size limit of an unpacked message; those of joints have some hundred bytes, pictures a few MB."""

MOST_DEFINITION_BYTES = 2**20
"""Size limit of what defines the messages of a topic; the largest of ROS has some ten thousand bytes."""
MOST_FIELDS = 1000
"""Limit of fields and constants in one kind of message: the time to parse them grows with their square."""

_MOST_JSON_BYTES = 2**24
_LARGE = 2**20
"""Messages of more bytes are walked through before they are decoded, since they may consist of tiny parts."""
_MOST_WINDOW = 2**27
_ZSTD, _LZ4 = b"\x28\xb5\x2f\xfd", b"\x04\x22\x4d\x18"
_JOINT_STATE = "sensor_msgs/msg/JointState"
# https://docs.ros2.org/latest/api/sensor_msgs/msg/JointState.html, for files that carry no definition of it.
_JOINT_STATE_TEXT = f"""std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{"=" * 80}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
"""

# The first two bytes of a message: Table 60 of the DDS-XTypes specification 1.3 (big endian is even, little odd), and
# the numbers of before (https://www.omg.org/spec/DDS-XTYPES/1.3).
_PLAIN = (0x00, 0x01)
_ENCAPSULATIONS = {
    0x02: "PL_CDR (a parameter list)",
    0x04: "XML",
    0x06: "CDR2 (XCDR2)",
    0x08: "D_CDR2 (XCDR2, delimited)",
    0x0A: "PL_CDR2 (XCDR2, a parameter list)",
    0x10: "CDR2 (XCDR2)",
    0x12: "PL_CDR2 (XCDR2, a parameter list)",
    0x14: "D_CDR2 (XCDR2, delimited)",
}


def decoder_of(encoding: str, schema: Any) -> Callable[[bytes], Any]:
    """The function that decodes the messages of a channel; it raises ValueError on those that are not as it says.

    Args:
        encoding: of the messages, as the channel states it: `json`, `cdr` or `protobuf`.
        schema: the channel's schema, with `name`, `encoding` and `data`, or None.

    Raises:
        ValueError: the encoding is not supported.
    """
    if encoding == "json":
        return _decode_json
    if encoding == "protobuf" and schema is not None:
        return _protobuf_decoder(schema)
    if encoding != "cdr" or schema is None:
        raise ValueError(f"messages in '{encoding}' are not read; JSON and ROS 2 (CDR) are, protobuf with its schema")
    return CdrDecoder(schema)


@final
class CdrDecoder:
    """Decodes the ROS 2 messages of a channel; raises ValueError on those that are not as it says."""

    def __init__(self, schema: Any) -> None:
        """For a channel's schema, with `name`, `encoding` and `data`.

        Raises:
            ValueError: its definition is of a kind that is not read.
        """
        self._name, self._text = schema.name, _ros2_definition(schema)
        from mcap_ros2._dynamic import generate_dynamic

        with _silence():
            self._decode = generate_dynamic(self._name, self._text)[self._name]

    def __call__(self, data: bytes) -> Any:
        """A decoded message."""
        data = plain_cdr(unpacked(data))
        if len(data) > _LARGE:
            self.locate(data)
        return self._decode(data)

    def locate(self, data: bytes) -> Located:
        """Where the numbers of a message lie in its bytes.

        Raises:
            ValueError, KeyError: it is compressed, or not as its definition says.
        """
        return locate(plain_cdr(data), self._definitions[self._name], self._definitions)

    @cached_property
    def _definitions(self) -> dict[str, Any]:
        """The definition of each kind of message, as the decoder has them."""
        from mcap_ros2._dynamic import TimeDefinition, _for_each_msgdef

        found: dict[str, Any] = dict.fromkeys(
            ("builtin_interfaces/Time", "builtin_interfaces/Duration"), TimeDefinition
        )

        def keep(name: str, short_name: str, definition: Any) -> None:
            found[name] = found[short_name] = definition

        with _silence():
            _for_each_msgdef(self._name, self._text, keep)
        return found


def unpacked(data: bytes) -> bytes:
    """A message's bytes; those that the recorder compressed one by one (rosbag2's message mode) are unpacked.

    Raises:
        ValueError: it unpacks to more than `MOST_MESSAGE_BYTES`, or is damaged.
    """
    if data[:4] == _ZSTD:
        import zstandard

        # As a stream, since decompress() allocates what the data's header claims.
        with zstandard.ZstdDecompressor(max_window_size=_MOST_WINDOW).stream_reader(data) as reader:
            found = reader.read(MOST_MESSAGE_BYTES + 1)
    elif data[:4] == _LZ4:
        from lz4.frame import LZ4FrameDecompressor

        found = LZ4FrameDecompressor().decompress(data, max_length=MOST_MESSAGE_BYTES + 1)
    else:
        return data
    if len(found) > MOST_MESSAGE_BYTES:
        raise ValueError(f"a compressed message unpacks to more than {MOST_MESSAGE_BYTES:,} bytes")
    return found


def plain_cdr(data: bytes) -> bytes:
    """The same bytes, if they are encoded as plain CDR, version 1.

    Raises:
        ValueError: the message begins with the mark of another encoding, which it names, or of none.
    """
    if len(data) >= 4 and data[0] == 0 and data[1] in _PLAIN:
        return data
    name = _ENCAPSULATIONS.get(data[1] & ~1) if len(data) >= 4 and data[0] == 0 else None
    what = f"it is encoded as {name}" if name else f"it begins with {data[:4].hex(' ')}, the mark of no CDR"
    raise ValueError(f"{what}; plain CDR (XCDR1) is read: record with another middleware setting, or convert the bag")


def check_definition(text: str) -> None:
    """See that a definition of messages can be parsed in no time.

    Raises:
        ValueError: it is far longer than any, or one of its kinds of message has far more fields.
    """
    if len(text) > MOST_DEFINITION_BYTES:
        raise ValueError(f"their definition has {len(text):,} characters; at most {MOST_DEFINITION_BYTES:,} are read")
    for kind in re.split(r"^={3,}", text, flags=re.MULTILINE):
        if sum(line.strip()[:1] not in ("", "#") for line in kind.splitlines()) > MOST_FIELDS:
            raise ValueError(f"their definition has more than {MOST_FIELDS:,} fields in one kind of message")


def _decode_json(data: bytes) -> Any:
    data = unpacked(data)
    if len(data) > _MOST_JSON_BYTES:
        raise ValueError(f"a message has {len(data):,} bytes; at most {_MOST_JSON_BYTES:,} are read")
    return json.loads(data)


@contextmanager
def _silence() -> Iterator[None]:
    """Keep a parser's own messages from the terminal: they quote the definition as it is, with its escapes."""
    with redirect_stdout(StringIO()), redirect_stderr(StringIO()):
        yield


def _ros2_definition(schema: Any) -> str:
    """The text that defines a channel's messages.

    Raises:
        ValueError: it is of a kind that is not read.
    """
    text = schema.data.decode("utf-8", "replace")
    check_definition(text)
    if schema.name == _JOINT_STATE and (schema.encoding != "ros2msg" or not text.strip()):
        text = _JOINT_STATE_TEXT
    elif schema.encoding != "ros2msg":
        raise ValueError(f"their definition is in '{schema.encoding}'; ros2msg is read")
    if re.search(r"\[\s*0+\s*\]", text):
        # Such an array takes no bytes, so a message could claim any number of them.
        raise ValueError("their definition has an array of no length")
    return text


def _protobuf_decoder(schema: Any) -> Callable[[bytes], Any]:
    if len(schema.data) > MOST_DEFINITION_BYTES:
        raise ValueError(f"their definition has {len(schema.data):,} bytes; at most {MOST_DEFINITION_BYTES:,} are read")
    if schema.encoding != "protobuf":
        raise ValueError(f"their definition is in '{schema.encoding}'; protobuf is read")
    try:
        from mcap_protobuf.decoder import DecoderFactory
    except ImportError:
        raise ValueError(
            "messages in 'protobuf' need the extra `protobuf`: pip install 'estexp_jax[protobuf]'"
        ) from None
    decode = DecoderFactory().decoder_for("protobuf", schema)
    if decode is None:
        raise ValueError("their definition does not hold their kind")
    return decode
