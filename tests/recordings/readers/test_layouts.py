"""Messages of known shape are read from their bytes: the same samples as by decoding each, in far fewer decodings."""

import numpy as np
import pytest

from estexp_jax.recordings.readers.decoding import CdrDecoder
from estexp_jax.recordings.readers.topics import TopicMerger
from estexp_jax.recordings.table import Selection
from tests.recordings.readers.forms import JOINT_STATE, Schema

KIND = "sensor_msgs/msg/JointState"


def _messages(shapes, n=60):
    """Joint states at 10 ms, of shapes (names, frame) that follow each other."""
    dynamic = pytest.importorskip("mcap_ros2._dynamic")
    serialize = dynamic.serialize_dynamic(KIND, JOINT_STATE)[KIND]
    for row in range(n):
        names, frame = shapes[row % len(shapes)]
        header = {"stamp": {"sec": 1000, "nanosec": 10_000_000 * row}, "frame_id": frame}
        values = [float(row) if k % 7 else np.nan for k in range(len(names))]
        yield serialize({"header": header, "name": names, "position": values, "velocity": values, "effort": []})


def _read(messages, wanted, clock, monkeypatch, fast):
    decoded = []

    def counted(self, data):
        decoded.append(data)
        return decode(self, data)

    def unknown(self, data):
        raise ValueError("not located")

    with monkeypatch.context() as patched:
        decode = CdrDecoder.__call__
        patched.setattr(CdrDecoder, "__call__", counted)
        if not fast:
            patched.setattr(CdrDecoder, "locate", unknown)
        merger = TopicMerger("a.log", Selection(wanted=wanted, clock=clock))
        merger.open(1, "/s", lambda: CdrDecoder(Schema(KIND, JOINT_STATE)))
        for row, message in enumerate(messages):
            merger.add(1, message, 10**9 + 10_000_000 * row, 2 * 10**9 + 10_000_000 * row)
        return merger.table([]), len(decoded)


SHAPES = {
    "one": [(["elbow", "wrist"], "base")],
    "the order changes": [(["elbow", "wrist"], "base"), (["wrist", "elbow"], "base")],
    "others between": [(["elbow", "wrist"], "base"), (["finger"], ""), (["elbow", "wrist"], "tool")],
    "a joint more": [(["wrist"], ""), (["elbow", "wrist"], "")],
}


@pytest.mark.parametrize("shapes", SHAPES.values(), ids=SHAPES.keys())
@pytest.mark.parametrize("clock", ["log", "publish", "header"])
@pytest.mark.parametrize("wanted", [frozenset({"/s.position[elbow]", "/s.velocity[wrist]"}), None])
def test_the_same_samples_as_by_decoding_each(shapes, clock, wanted, monkeypatch):
    messages = list(_messages(shapes))
    slow, n_slow = _read(messages, wanted, clock, monkeypatch, fast=False)
    fast, n_fast = _read(messages, wanted, clock, monkeypatch, fast=True)
    assert n_slow == len(messages) and n_fast <= 3 * len(shapes)
    assert list(fast.columns) == list(slow.columns)
    for name, values in slow.columns.items():
        np.testing.assert_array_equal(fast.columns[name], values)


def test_shapes_without_end_are_not_remembered_without_end(monkeypatch):
    shapes = [(["elbow", "wrist"], "x" * k) for k in range(300)]
    table, _ = _read(list(_messages(shapes, 300)), frozenset({"/s.position[wrist]"}), "log", monkeypatch, fast=True)
    np.testing.assert_array_equal(table.column("/s.position[wrist]"), np.arange(300))
