"""Bags of ROS 1 and 2, written by `rosbags` and by an MCAP writer, are the same log."""

import shutil
import sys

import numpy as np
import pytest

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.read import read_table
from estexp_jax.recordings.table import Selection
from tests.recordings.readers.forms import write_mcap

STATE = "/joint_states.position[elbow]"


@pytest.fixture
def rosbags():
    return pytest.importorskip("rosbags.highlevel", reason="needs the extra `ros`: pip install 'estexp_jax[ros]'")


def _messages(store, seconds=True):
    """Joint states at 100 Hz, whose names change places."""
    kinds = store.types
    for k in range(40):
        pair = [("shoulder", 0.5), ("elbow", 0.1 * k)][:: -1 if k % 2 else 1]
        stamp = kinds["builtin_interfaces/msg/Time"](sec=1_700_000_000, nanosec=k * 10_000_000)
        header = {"stamp": stamp, "frame_id": ""} | ({} if seconds else {"seq": k})
        yield (
            1_700_000_000_000_000_000 + k * 10_000_000,
            kinds["sensor_msgs/msg/JointState"](
                header=kinds["std_msgs/msg/Header"](**header),
                name=[name for name, _ in pair],
                position=np.array([value for _, value in pair]),
                velocity=np.array([]),
                effort=np.array([]),
            ),
        )


def _write_bag2(path, storage="SQLITE3", mode="NONE"):
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    writer = Writer(path, version=9, storage_plugin=StoragePlugin[storage])
    if mode != "NONE":
        writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
    with writer:
        connection = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for time, message in _messages(store):
            writer.write(connection, time, store.serialize_cdr(message, connection.msgtype))
    return path


def _check(table):
    np.testing.assert_allclose(table.column(STATE), 0.1 * np.arange(40))
    np.testing.assert_allclose(table.column("time"), 0.01 * np.arange(40), atol=1e-9)


@pytest.mark.parametrize("clock", ["log", "header"])
@pytest.mark.parametrize(("storage", "mode"), [("SQLITE3", "NONE"), ("SQLITE3", "MESSAGE"), ("SQLITE3", "FILE")])
def test_sqlite_bags(tmp_path, rosbags, storage, mode, clock):
    path = _write_bag2(tmp_path / "run", storage, mode)
    _check(read_table(path, Selection(wanted=frozenset({STATE}), clock=clock)))


def test_mcap_bags_with_a_description(tmp_path, rosbags):
    path = _write_bag2(tmp_path / "run", "MCAP")
    pytest.importorskip("mcap_ros2")
    _check(read_table(path, Selection(wanted=frozenset({STATE}))))


def test_single_database(tmp_path, rosbags):
    [path] = _write_bag2(tmp_path / "run").glob("*.db3")
    _check(read_table(path))
    assert STATE in read_table(path).names


def test_ros_1_bags(tmp_path, rosbags):
    from rosbags.rosbag1 import Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS1_NOETIC)
    with Writer(tmp_path / "a.bag") as writer:
        connection = writer.add_connection("/joint_states", "sensor_msgs/msg/JointState", typestore=store)
        for time, message in _messages(store, seconds=False):
            writer.write(connection, time, store.serialize_ros1(message, connection.msgtype))
    for clock in ("log", "header"):
        _check(read_table(tmp_path / "a.bag", Selection(clock=clock)))


def test_split_bags_are_one_log_and_other_logs_in_a_folder_are_not(tmp_path):
    pytest.importorskip("mcap_ros2", reason="MCAP needs the extra `mcap`: pip install 'estexp_jax[mcap]'")
    folder, time = tmp_path / "run", np.arange(30) * 0.01
    folder.mkdir()
    for k, rows in enumerate((slice(0, 10), slice(10, 20), slice(20, 30))):
        write_mcap(folder / f"run_{9 + k}.mcap", time[rows], np.sin(time[rows]), np.cos(time[rows]))
    wanted = Selection(wanted=frozenset({STATE}))
    np.testing.assert_array_equal(read_table(folder, wanted).column(STATE), np.cos(time))
    (folder / "metadata.yaml").write_text("a:\n  relative_file_paths:\n    - run_9.mcap\n    - 'run_10.mcap'\n")
    np.testing.assert_array_equal(read_table(folder, wanted).column(STATE), np.cos(time[:20]))
    (folder / "metadata.yaml").unlink()
    shutil.copy(folder / "run_9.mcap", folder / "other.mcap")
    with pytest.raises(InputError, match="is a folder, not a recording"):
        read_table(folder, wanted)


@pytest.mark.parametrize("name", ["a.bag", "a.db3"])
def test_what_is_no_bag_is_told(tmp_path, rosbags, name):
    for content in (b"", b"#ROSBAG V2.0\n" + b"\xff" * 500, b"SQLite format 3\x00" + bytes(2000)):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match="is not a ROS bag, or is damaged"):
            read_table(tmp_path / name)


def test_without_the_extra_it_is_told_what_to_install(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "rosbags.highlevel", None)
    (tmp_path / "a.bag").write_bytes(b"")
    with pytest.raises(InputError, match=r"needs the extra `ros`; pip install 'estexp_jax\[ros\]'"):
        read_table(tmp_path / "a.bag")


def test_definitions_and_descriptions_without_end_are_refused(rosbags, tmp_path, monkeypatch):
    from estexp_jax.recordings.readers import decoding, rosbag

    _write_bag2(tmp_path / "bag")
    monkeypatch.setattr(decoding, "MOST_FIELDS", 2)
    with pytest.raises(InputError, match="more than 2 fields"):
        read_table(tmp_path / "bag", Selection(wanted=frozenset({STATE})))
    monkeypatch.undo()
    monkeypatch.setattr(rosbag, "_MOST_BYTES", 20)
    with pytest.raises(InputError, match=r"metadata.yaml: is [0-9]+ bytes long; at most 20"):
        read_table(tmp_path / "bag", Selection(wanted=frozenset({STATE})))
