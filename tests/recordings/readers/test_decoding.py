"""Messages of robot logs: encodings that are read, unpacked or refused by their names."""

import json
from types import SimpleNamespace

import pytest

from estexp_jax.recordings.readers import decoding
from estexp_jax.recordings.readers.decoding import decoder_of, plain_cdr, unpacked


def test_unsupported_encodings_are_refused():
    assert decoder_of("json", None)(b'{"x": 1}') == {"x": 1}
    with pytest.raises(ValueError, match="'cbor' are not read"):
        decoder_of("cbor", None)
    with pytest.raises(ValueError, match="'protobuf' are not read"):
        decoder_of("protobuf", None)
    with pytest.raises(ValueError, match="ros2msg is read"):
        decoder_of("cdr", SimpleNamespace(name="a/A", encoding="omgidl", data=b"x"))
    with pytest.raises(ValueError, match="array of no length"):
        decoder_of("cdr", SimpleNamespace(name="a/A", encoding="ros2msg", data=b"float64[0] x"))


@pytest.mark.parametrize(
    ("mark", "name"),
    [
        ("00 02", "PL_CDR"),
        ("00 03", "PL_CDR"),
        ("00 06", "XCDR2"),
        ("00 07", "XCDR2"),
        ("00 09", "D_CDR2"),
        ("00 0b", "PL_CDR2"),
        ("00 11", "XCDR2"),
        ("00 15", "D_CDR2"),
        ("28 b5", "mark of no CDR"),
    ],
)
def test_other_encapsulations_are_refused_by_name(mark, name):
    assert plain_cdr(bytes.fromhex("00 01 00 00 2a")) == bytes.fromhex("00 01 00 00 2a")
    with pytest.raises(ValueError, match=name):
        plain_cdr(bytes.fromhex(mark + "00 00 2a 00 00 00"))


@pytest.mark.parametrize("kind", ["zstandard", "lz4.frame"])
def test_compressed_messages_are_unpacked_up_to_a_bound(kind, monkeypatch):
    module = pytest.importorskip(kind)
    pack = module.ZstdCompressor().compress if kind == "zstandard" else module.compress
    data = json.dumps({"x": 2, "s": " " * 5000}).encode()
    assert unpacked(pack(data)) == data and decoder_of("json", None)(pack(data))["x"] == 2
    monkeypatch.setattr(decoding, "MOST_MESSAGE_BYTES", 4000)
    with pytest.raises(ValueError, match="unpacks to more than 4,000 bytes"):
        unpacked(pack(data))
