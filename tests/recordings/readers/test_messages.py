"""Decoded messages: paths to numbers, by index or by name, and stamps."""

import pytest

from estexp_jax.recordings.readers.messages import (
    Named,
    follow,
    message_number,
    name_at,
    nanoseconds,
    numbers_in,
    path_in,
)

STATE = {"name": ["shoulder", "elbow"], "position": [0.5, 0.7], "a.b": {"c": 3}, "stamp": {"sec": 2, "nanosec": 5}}


@pytest.mark.parametrize(
    ("path", "steps", "value"),
    [
        (".position[1]", ("position", 1), 0.7),
        (".position[elbow]", ("position", Named("elbow", "name", 0)), 0.7),
        (".a.b.c", ("a.b", "c"), 3),
    ],
)
def test_a_path_leads_to_its_value(path, steps, value):
    assert path_in(STATE, path) == steps
    assert follow(STATE, steps) == value


def test_paths_that_do_not_exist_are_none():
    assert path_in(STATE, ".velocity") is None and path_in(STATE, ".name.x") is None
    wrist, elbow = Named("wrist", "name", 0), Named("elbow", "name", 0)
    assert follow(STATE, ("position", 7)) is None and follow(STATE, ("position", wrist)) is None
    assert follow({**STATE, "name": ["elbow", "shoulder"]}, ("position", elbow)) == 0.5
    assert follow({**STATE, "name": ["elbow"]}, ("position", elbow)) is None


TRAJECTORY = {"joint_names": ["b", "a"], "points": [{"positions": [1.0, 2.0], "velocities": []}]}
FOXGLOVE = {"joints": [{"name": "b", "position": 1.0}, {"name": "a", "position": 2.0}]}
DYNAMIC = {
    "joint_names": ["b", "a"],
    "interface_values": [
        {"interface_names": ["position", "effort"], "values": [1.0, 8.0]},
        {"interface_names": ["position", "effort"], "values": [2.0, 9.0]},
    ],
}


@pytest.mark.parametrize(
    ("message", "path"),
    [
        (TRAJECTORY, ".points[0].positions[a]"),
        (FOXGLOVE, ".joints[a].position"),
        (DYNAMIC, ".interface_values[a].values[position]"),
    ],
)
def test_names_stand_in_lists_of_any_name_further_out_or_in_the_values(message, path):
    steps = path_in(message, path)
    assert steps is not None and follow(message, steps) == 2.0
    assert path in set(numbers_in(message)) and path.replace("[a]", "[1]") not in set(numbers_in(message))
    assert path_in(message, path.replace("[a]", "[c]")) is None


def test_an_index_leads_to_a_value_with_a_name():
    assert name_at(TRAJECTORY, ("points", 0, "positions", 1)) == "a" and name_at(FOXGLOVE, ("joints", 0)) == "b"
    assert name_at({"position": [1.0]}, ("position", 0)) is None


def test_stamps_are_nanoseconds_and_numbers_are_floats():
    assert nanoseconds(STATE["stamp"]) == 2_000_000_005 and nanoseconds(1.5) == 1_500_000_000
    assert nanoseconds({"sec": 1}) is None and nanoseconds(True) is None and nanoseconds(1e300) is None
    assert message_number(STATE["stamp"]) == pytest.approx(2.000000005)
    assert message_number(True) == 1.0 and message_number("x") is None and message_number(10**400) is None


def test_numbers_are_listed_by_path():
    expected = [".position[shoulder]", ".position[elbow]", ".a.b.c", ".stamp.sec", ".stamp.nanosec"]
    assert list(numbers_in(STATE)) == expected
    assert list(numbers_in({"name": ["7", "a[b]"], "q": [0, 1]})) == [".q[0]", ".q[1]"]
    assert list(numbers_in({"picture": [0] * 1000})) == []
