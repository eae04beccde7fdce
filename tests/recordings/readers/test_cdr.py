"""Places of numbers in messages: where the decoder of the format's library reads them."""

import struct
from typing import Any

import numpy as np
import pytest

from estexp_jax.recordings.readers.cdr import Place, Places
from estexp_jax.recordings.readers.decoding import CdrDecoder
from tests.recordings.readers.forms import JOINT_STATE, Schema

MIXED = """bool on
string text
int16[3] small
a/Inner[] inner
uint8[] picture
float32 x
int64 y
================================================================================
MSG: a/Inner
string name
float64 value
"""


def _numbers(located, data, value=None) -> Any:
    """The located message with its numbers read."""
    value = located.message if value is None else value
    if isinstance(value, Place):
        return struct.unpack_from(located.order + value.code, data, value.offset)[0]
    if isinstance(value, dict):
        return {key: _numbers(located, data, each) for key, each in value.items()}
    return [_numbers(located, data, each) for each in value] if isinstance(value, list | Places) else value


def _plain(value):
    if hasattr(value, "__slots__"):
        return {key: _plain(getattr(value, key)) for key in value.__slots__}
    return [_plain(each) for each in value] if isinstance(value, list | bytes) else value


@pytest.mark.parametrize("seed", range(20))
def test_every_number_is_found_where_the_decoder_reads_it(seed):
    dynamic = pytest.importorskip("mcap_ros2._dynamic")
    random = np.random.default_rng(seed)
    inner = [{"name": "n" * random.integers(9), "value": random.normal()} for _ in range(random.integers(4))]
    message = {"on": seed % 2 == 0, "text": "t" * random.integers(9), "small": [1, -2, 3], "inner": inner}
    message |= {"picture": list(bytes(range(random.integers(6)))), "x": 0.5, "y": -(2**40)}
    data = dynamic.serialize_dynamic("a/Mixed", MIXED)["a/Mixed"](message)
    decoder = CdrDecoder(Schema("a/Mixed", MIXED))
    located = decoder.locate(data)
    assert _numbers(located, data) == _plain(decoder(data))
    for stop in range(4, len(data), 3):
        with pytest.raises(ValueError, match="ends early"):
            decoder.locate(data[:stop])


def test_big_endian_messages():
    pytest.importorskip("mcap_ros2")
    data = b"\0\0\0\0" + struct.pack(">iI", 5, 7) + struct.pack(">I2s", 2, b"f\0")
    data += b"\0\0" + struct.pack(">I", 0) + struct.pack(">I", 1) + struct.pack(">d", 0.25) + struct.pack(">II", 0, 0)
    decoder = CdrDecoder(Schema("sensor_msgs/msg/JointState", JOINT_STATE))
    found = _numbers(decoder.locate(data), data)
    assert found["header"] == {"stamp": {"sec": 5, "nanosec": 7}, "frame_id": "f"}
    assert found == _plain(decoder(data)) and found["position"] == [0.25]
