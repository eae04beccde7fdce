"""MCAP: topics with clocks of their own, and being told what is wrong."""

import json
import re
import sys

import numpy as np
import pytest

from estexp_jax.cli.main import main
from estexp_jax.errors import InputError
from estexp_jax.recordings.readers import mcap_chunks
from estexp_jax.recordings.readers.read import read_table
from estexp_jax.recordings.table import Selection
from tests.recordings.readers.forms import JOINT_STATE, write_mcap

STATE, GOAL = "/joint_states.position[elbow]", "/goal.position[0]"


@pytest.fixture(autouse=True)
def mcap_installed():
    pytest.importorskip("mcap_ros2", reason="MCAP needs the extra `mcap`: pip install 'estexp_jax[mcap]'")


def _read(path, *wanted, clock="log"):
    return read_table(path, Selection(wanted=frozenset(wanted) or None, clock=clock))


def _write(path, messages, *, encoding="json", schema=None, compression="NONE"):
    """A file of (topic, time in ns, bytes)."""
    from mcap.writer import CompressionType, Writer

    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType[compression])
        writer.start()
        number = writer.register_schema(*schema) if schema else 0
        channels = {topic: writer.register_channel(topic, encoding, number) for topic, _, _ in messages}
        for topic, time, data in messages:
            writer.add_message(channels[topic], log_time=time, publish_time=time + 5, data=data)
        writer.finish()
    return path


def _json(**fields):
    return json.dumps(fields).encode()


def test_topics_are_merged_on_the_union_of_their_times(tmp_path):
    messages = [("/a", 0, _json(x=1.0)), ("/b", 4_000_000, _json(y=[5, 6])), ("/a", 10_000_000, _json(x=2.0))]
    messages += [("/b", 10_000_000, _json(y=[7, 8])), ("/noise", 3_000_000, _json(z=1))]
    table = _read(_write(tmp_path / "a.mcap", messages), "/a.x", "/b.y[1]")
    np.testing.assert_allclose(table.column("time"), [0.0, 0.004, 0.010])
    np.testing.assert_array_equal(table.column("/a.x"), [1.0, np.nan, 2.0])
    np.testing.assert_array_equal(table.column("/b.y[1]"), [np.nan, 6.0, 8.0])
    assert table.notes == ("topics that were not asked for: /noise",)


def test_joints_are_found_by_name_though_their_order_changes(tmp_path):
    time = np.arange(20) * 0.01
    write_mcap(tmp_path / "a.mcap", time, np.sin(time), np.cos(time))
    table = _read(tmp_path / "a.mcap", STATE, GOAL)
    np.testing.assert_array_equal(table.column(STATE), np.cos(time))
    with pytest.raises(InputError, match=r"order of the names changes: .position\[0\] is 'shoulder' in one .* 'elbow'"):
        _read(tmp_path / "a.mcap", "/joint_states.position[0]")
    everything = _read(tmp_path / "a.mcap")
    assert STATE in everything.names and "/goal.position[0]" in everything.names
    with pytest.raises(InputError, match=r"topic '/camera': messages in 'protobuf' are not read; JSON and ROS 2"):
        everything.column("/camera")


def test_clocks(tmp_path):
    time = np.arange(20) * 0.01
    write_mcap(tmp_path / "a.mcap", time, np.full(20, np.nan), time)
    for clock in ("log", "publish", "header"):
        np.testing.assert_allclose(_read(tmp_path / "a.mcap", STATE, clock=clock).column("time"), time, atol=1e-9)
    _write(tmp_path / "b.mcap", [("/a", 0, _json(x=1))])
    with pytest.raises(InputError, match=r"topic '/a': a message has no time on the clock 'header'"):
        _read(tmp_path / "b.mcap", "/a.x", clock="header")


@pytest.mark.parametrize("compression", ["NONE", "LZ4", "ZSTD"])
def test_compressions_and_names_with_dots(tmp_path, compression):
    messages = [("/a", k, _json(**{"left.arm": {"q": k}})) for k in range(50)]
    table = _read(_write(tmp_path / "a.mcap", messages, compression=compression), "/a.left.arm.q")
    np.testing.assert_array_equal(table.column("/a.left.arm.q"), np.arange(50.0))


def test_two_messages_of_one_time(tmp_path):
    table = _read(_write(tmp_path / "a.mcap", [("/a", 0, _json(x=1)), ("/a", 0, _json(x=2))]), "/a.x")
    np.testing.assert_array_equal(table.column("/a.x"), [2.0])
    assert "1 messages have the time of another one" in table.notes[0]


def test_joint_states_without_a_definition(tmp_path):
    from mcap_ros2._dynamic import serialize_dynamic

    name = "sensor_msgs/msg/JointState"
    data = serialize_dynamic(name, JOINT_STATE)[name]({"name": ["elbow"], "position": [0.5]})
    path = _write(tmp_path / "a.mcap", [("/j", 0, data)], encoding="cdr", schema=(name, "ros2idl", b"module x {}"))
    np.testing.assert_array_equal(_read(path, "/j.position[elbow]").column("/j.position[elbow]"), [0.5])


@pytest.mark.parametrize(
    ("wanted", "message"),
    [
        ("/b.x", r"no topic for '/b\.x'; a path such as .*topics are: /a"),
        ("/a.y", r"'/a\.y': no message has a number there"),
        ("/a.x[0]", r"no message has a number there"),
        ("/a.s", r"no message has a number there"),
        ("/a.x.__class__", r"no message has a number there"),
        ("/a[", r"no message has a number there"),
    ],
)
def test_paths_that_lead_nowhere(tmp_path, wanted, message):
    path = _write(tmp_path / "a.mcap", [("/a", 0, _json(x=1, s="<b>text</b>"))])
    with pytest.raises(InputError, match=message):
        _read(path, wanted).column(wanted)


def test_a_file_that_ends_in_the_middle_is_read_so_far(tmp_path):
    time = np.arange(2000) * 0.01
    write_mcap(tmp_path / "a.mcap", time, np.sin(time), np.cos(time))
    whole = (tmp_path / "a.mcap").read_bytes()
    (tmp_path / "b.mcap").write_bytes(whole[: len(whole) // 3])
    table = _read(tmp_path / "b.mcap", STATE)
    rows = len(table.column(STATE))
    assert 10 < rows < 1500 and "ends in the middle" in table.notes[0]
    np.testing.assert_array_equal(table.column(STATE), np.cos(time[:rows]))


@pytest.mark.parametrize("content", [b"", b"\x89MCAP0\r\n", b"time,x\n0,1\n", b"\x89MCAP0\r\n" + b"\xff" * 1000])
def test_what_is_no_mcap_is_told(tmp_path, content):
    (tmp_path / "a.mcap").write_bytes(content)
    with pytest.raises(InputError, match=r"a\.mcap: is not an MCAP file"):
        _read(tmp_path / "a.mcap", "/a.x")


@pytest.mark.parametrize("compression", ["ZSTD", "LZ4"])
def test_chunks_that_unpack_to_more_than_they_may_are_refused(tmp_path, monkeypatch, compression):
    _write(tmp_path / "a.mcap", [("/a", 0, _json(x=1, s=" " * 1_000_000))], compression=compression)
    assert (tmp_path / "a.mcap").stat().st_size < 50_000
    monkeypatch.setattr(mcap_chunks, "MOST_CHUNK_BYTES", 100_000)
    with pytest.raises(InputError, match=r"a chunk claims to unpack to 1,000,\d+ bytes"):
        _read(tmp_path / "a.mcap", "/a.x")


@pytest.mark.parametrize(
    "definition", [b"float64[0] x\nfloat64 y", b"Nothing x", b"\xff", b"float64 x y z", b"[" * 500]
)
def test_hostile_definitions(tmp_path, definition):
    path = _write(
        tmp_path / "a.mcap", [("/a", 0, b"\x00\x01\x00\x00" * 9)], encoding="cdr", schema=("a/A", "ros2msg", definition)
    )
    with pytest.raises(InputError):
        _read(path, "/a.x").column("/a.x")


def test_without_the_extra_it_is_told_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "mcap", None)
    with pytest.raises(InputError, match=r"needs the extra `mcap`; pip install 'estexp_jax\[mcap\]'"):
        _read(_write_nothing(tmp_path / "a.mcap"), "/a.x")


def _write_nothing(path):
    path.write_bytes(b"")
    return path


def test_bytes_that_changed_on_the_way_are_noticed(tmp_path):
    path = _write(tmp_path / "a.mcap", [("/a", k, _json(x=123456)) for k in range(9)])
    path.write_bytes(path.read_bytes().replace(b"123456", b"123457", 1))
    with pytest.raises(InputError, match=r"damaged: crc validation failed"):
        _read(path, "/a.x")


def test_a_file_cut_anywhere_is_read_as_far_as_it_goes(tmp_path):
    """One chunk holds it all, so each cut is inside a record."""
    time = np.arange(60) * 0.01
    for compression in ("NONE", "ZSTD", "LZ4"):
        messages = [("/a", int(1e9 * t), _json(x=float(np.sin(t)), s="padding" * 9)) for t in time]
        whole = _write(tmp_path / "a.mcap", messages, compression=compression).read_bytes()
        counts = set()
        for stop in range(0, len(whole), max(len(whole) // 150, 1)):
            (tmp_path / "b.mcap").write_bytes(whole[:stop])
            try:
                values = _read(tmp_path / "b.mcap", "/a.x").column("/a.x")
            except InputError as error:
                assert "is not an MCAP file, or ends before any message" in str(error)
            else:
                counts.add(len(values))
                np.testing.assert_array_equal(values, np.sin(time)[: len(values)])
        assert max(counts) == 60 and len(counts) > (50 if compression == "NONE" else 0)


@pytest.mark.parametrize("suffix", [".zstd", ".zst"])
def test_a_file_compressed_as_a_whole(tmp_path, suffix, monkeypatch):
    zstandard = pytest.importorskip("zstandard")
    whole = _write(tmp_path / "a.mcap", [("/a", k, _json(x=k)) for k in range(1, 50)]).read_bytes()
    path = tmp_path / f"a.mcap{suffix}"
    path.write_bytes(zstandard.ZstdCompressor().compress(whole))
    np.testing.assert_array_equal(_read(path, "/a.x").column("/a.x"), np.arange(1.0, 50.0))
    monkeypatch.setattr(mcap_chunks, "_FEW_BYTES", 1000)
    path.write_bytes(zstandard.ZstdCompressor().compress(whole[:8] + bytes(10**7)))
    with pytest.raises(InputError, match="unpacks to more than 1000 times its size"):
        _read(path, "/a.x")


def test_messages_compressed_one_by_one_are_unpacked(tmp_path):
    zstandard = pytest.importorskip("zstandard")
    from mcap_ros2._dynamic import serialize_dynamic

    name = "sensor_msgs/msg/JointState"
    encode = serialize_dynamic(name, JOINT_STATE)[name]
    pack = zstandard.ZstdCompressor().compress
    data = [(t, pack(encode({"name": ["elbow"], "position": [0.1 * t]}))) for t in range(9)]
    schema = (name, "ros2msg", JOINT_STATE.encode())
    path = _write(tmp_path / "a.mcap", [("/j", t, one) for t, one in data], encoding="cdr", schema=schema)
    np.testing.assert_allclose(_read(path, "/j.position[elbow]").column("/j.position[elbow]"), 0.1 * np.arange(9))


@pytest.mark.parametrize(("mark", "name"), [(2, "PL_CDR"), (7, "CDR2 .XCDR2."), (9, "D_CDR2")])
def test_other_encodings_than_cdr_are_refused_by_name(tmp_path, mark, name):
    from mcap_ros2._dynamic import serialize_dynamic

    text = "float64 x\nfloat64 y"
    data = bytearray(serialize_dynamic("a/A", text)["a/A"]({"x": 1.0, "y": 2.0}))
    data[1] = mark
    path = _write(
        tmp_path / "a.mcap", [("/a", 0, bytes(data))], encoding="cdr", schema=("a/A", "ros2msg", text.encode())
    )
    with pytest.raises(InputError, match=rf"topic '/a': a message cannot be decoded: it is encoded as {name}"):
        _read(path, "/a.x")
    assert "/a.x" not in _read_or_none(path)


def _read_or_none(path):
    try:
        return _read(path).names
    except InputError:
        return ()


def test_channels_of_one_topic_are_each_read_by_their_own_definition(tmp_path):
    from mcap.writer import Writer
    from mcap_ros2._dynamic import serialize_dynamic

    texts = ("float64 command\nfloat64 reading", "float64 reading\nfloat64 command")
    path = tmp_path / "a.mcap"
    with path.open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        for k, text in enumerate(texts):
            channel = writer.register_channel("/a", "cdr", writer.register_schema("a/A", "ros2msg", text.encode()))
            encode = serialize_dynamic("a/A", text)["a/A"]
            for t in range(k, 10, 2):
                writer.add_message(channel, t, encode({"command": 1.0, "reading": 2.0}), t)
        writer.finish()
    table = _read(path, "/a.command", "/a.reading")
    assert set(table.column("/a.command")) == {1.0} and set(table.column("/a.reading")) == {2.0}
    assert "topic /a has channels with different definitions; each is read by its own" in table.notes


def test_protobuf_messages(tmp_path):
    pytest.importorskip("mcap_protobuf", reason="needs the extra `protobuf`: pip install 'estexp_jax[protobuf]'")
    from google.protobuf.descriptor_pb2 import FileDescriptorSet
    from google.protobuf.duration_pb2 import Duration
    from mcap_protobuf.schema import build_file_descriptor_set

    files = build_file_descriptor_set(Duration)
    assert isinstance(files, FileDescriptorSet)
    schema = ("google.protobuf.Duration", "protobuf", files.SerializeToString())
    messages = [("/d", t, Duration(seconds=t, nanos=5).SerializeToString()) for t in range(1, 5)]
    path = _write(tmp_path / "a.mcap", messages, encoding="protobuf", schema=schema)
    np.testing.assert_array_equal(_read(path, "/d.seconds").column("/d.seconds"), np.arange(1.0, 5.0))
    assert _read(path).names == ("time", "/d.seconds", "/d.nanos")


def test_from_the_command_line(tmp_path, monkeypatch, pendulum_xml, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.xml").write_text(re.sub('(name|joint)="hinge"', r'\1="elbow"', pendulum_xml))
    time = np.arange(300) * 0.01
    write_mcap(tmp_path / "run.mcap", time, np.sin(3 * time), np.sin(3 * time - 0.1))
    maps = ["ctrl.servo.1=/goal.position[0]", "ctrl.actuator_1=/goal.position[0]", f"sensor.angle={STATE}"]
    mapped = [word for text in maps for word in ("--map", text)]
    assert main(["check", "arm.xml", "run.mcap", *mapped, "--out", "out"]) == 0
    judged = json.loads((tmp_path / "out" / "check.json").read_text())["recordings"][0]
    assert (judged["rows"], judged["joints"]["elbow"]["excited"]) == (300, True)
    assert judged["notes"] == ["topics that were not asked for: /camera"]
    assert main(["check", "arm.xml", "run.mcap", "--init"]) == 0
    assert "/goal.position[0]" in (tmp_path / "recordings.toml").read_text()
    assert main(["check", "arm.xml", "run.mcap", "--map", "ctrl.servo.1=/gaol.position[0]"]) == 2
    assert "no topic for '/gaol.position[0]'" in capsys.readouterr().err
