"""Messages of robot logs: encodings that are read, unpacked or refused by their names."""

import json
from types import SimpleNamespace

import pytest

from estexp_jax.recordings.readers import cdr, decoding
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


def ros2(text: str) -> SimpleNamespace:
    return SimpleNamespace(name="a/msg/A", encoding="ros2msg", data=text.encode())


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("".join(f"float64 f{k}\n" for k in range(decoding.MOST_FIELDS + 1)), "more than 1,000 fields"),
        ("float64 x\n===\nMSG: a/B\n" + "int32 C=1\n" * (decoding.MOST_FIELDS + 1), "more than 1,000 fields"),
        ("# " + "x" * decoding.MOST_DEFINITION_BYTES + "\nfloat64 x", "at most 1,048,576 are read"),
    ],
)
def test_definitions_without_end_are_refused(text, told):
    with pytest.raises(ValueError, match=told):
        decoder_of("cdr", ros2(text))


def test_comments_do_not_count():
    assert decoder_of("cdr", ros2("# said\n" * 5000 + "float64 x"))


def test_a_small_message_may_not_unpack_to_parts_without_end(monkeypatch):
    monkeypatch.setattr(cdr, "MOST_PARTS", 200)
    zstandard = pytest.importorskip("zstandard")
    decode = decoder_of("cdr", ros2("a/B[] x\n===\nMSG: a/B\nuint8 y\n"))
    bomb = b"\x00\x01\x00\x00" + (2**21).to_bytes(4, "little") + bytes(2**21)
    with pytest.raises(ValueError, match="more than 200 parts"):
        decode(zstandard.ZstdCompressor().compress(bomb))
    picture = decoder_of("cdr", ros2("uint8[] x"))
    assert len(picture(bomb).x) == 2**21


def test_long_texts_in_json_are_refused(monkeypatch):
    monkeypatch.setattr(decoding, "_MOST_JSON_BYTES", 20)
    with pytest.raises(ValueError, match="at most 20 are read"):
        decoder_of("json", None)(b'{"x": "' + b"a" * 20 + b'"}')


@pytest.mark.parametrize("text", ["float64 \x1b[31mx", "float64"])
def test_a_parser_quotes_nothing_on_the_terminal(text, capfd):
    with pytest.raises(Exception):  # noqa: B017 (whatever it raises is told as one message)
        decoder_of("cdr", ros2(text))
    assert capfd.readouterr() == ("", "")
