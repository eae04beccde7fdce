"""Decoded messages: paths to numbers, stamps, and encodings that are refused."""

import json
from types import SimpleNamespace

import pytest

from estexp_jax.recordings.readers.messages import decoder_of, follow, message_number, nanoseconds, numbers_in, path_in

STATE = {"name": ["shoulder", "elbow"], "position": [0.5, 0.7], "a.b": {"c": 3}, "stamp": {"sec": 2, "nanosec": 5}}


@pytest.mark.parametrize(
    ("path", "steps", "value"),
    [
        (".position[1]", ("position", 1), 0.7),
        (".position[elbow]", ("position", ("elbow",)), 0.7),
        (".a.b.c", ("a.b", "c"), 3),
    ],
)
def test_a_path_leads_to_its_value(path, steps, value):
    assert path_in(STATE, path) == steps
    assert follow(STATE, steps) == value


def test_paths_that_do_not_exist_are_none():
    assert path_in(STATE, ".velocity") is None and path_in(STATE, ".name.x") is None
    assert follow(STATE, ("position", 7)) is None and follow(STATE, ("position", ("wrist",))) is None
    assert follow({**STATE, "name": ["elbow", "shoulder"]}, ("position", ("elbow",))) == 0.5


def test_stamps_are_nanoseconds_and_numbers_are_floats():
    assert nanoseconds(STATE["stamp"]) == 2_000_000_005 and nanoseconds(1.5) == 1_500_000_000
    assert nanoseconds({"sec": 1}) is None and nanoseconds(True) is None and nanoseconds(1e300) is None
    assert message_number(STATE["stamp"]) == pytest.approx(2.000000005)
    assert message_number(True) == 1.0 and message_number("x") is None and message_number(10**400) is None


def test_numbers_are_listed_by_path():
    assert list(numbers_in(STATE)) == [".position[0]", ".position[1]", ".a.b.c", ".stamp.sec", ".stamp.nanosec"]
    assert list(numbers_in({"picture": [0] * 1000})) == []


def test_unsupported_encodings_are_refused():
    assert decoder_of("json", None) is json.loads
    with pytest.raises(ValueError, match="'protobuf' are not read"):
        decoder_of("protobuf", None)
    with pytest.raises(ValueError, match="ros2msg is read"):
        decoder_of("cdr", SimpleNamespace(name="a/A", encoding="omgidl", data=b"x"))
    with pytest.raises(ValueError, match="array of no length"):
        decoder_of("cdr", SimpleNamespace(name="a/A", encoding="ros2msg", data=b"float64[0] x"))
