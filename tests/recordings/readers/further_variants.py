"""More forms in which people have the log of `variants`: odd clocks, other writers, bags, and files cut short."""

import json
from itertools import product

import numpy as np
import pytest

from tests.recordings.readers.forms import JOINT_STATE
from tests.recordings.readers.variants import (
    JOINTS,
    ORDER,
    Truth,
    _arrow,
    _bag_rosbags,
    _joint_states,
    _lerobot,
    _mcap,
    _rows,
    _text,
)

_STATE = "sensor_msgs/msg/JointState"


def _durations(log):
    return np.round(1e9 * log.time).astype(np.int64).astype("timedelta64[ns]")


def _csv_absent(folder, log):
    """Words for what is absent, and switches in words, under our own name."""
    lines = [f"{row},True,NA,null" for row in _rows(log.columns)]
    return _text(folder, [",".join([*log.columns, "enable.m_elbow", "current", "note"]), *lines])


def _csv_two_starts(folder, log):
    """The logger began anew: a short log of something else before, with its own header."""
    other = [f"{0.01 * k!r},{','.join('9.5' for _ in range(6))}" for k in range(30)]
    header = ",".join(log.columns)
    return _text(folder, [header, *other, header, *_rows(log.columns)])


def _csv_readings_first(folder, log):
    """Readings begin before the first command."""
    early = [f"{-0.01 * k!r},,,,0.1,0.2,0.3" for k in (3, 2, 1)]
    return _text(folder, [",".join(log.columns), *early, *_rows(log.columns)])


def _csv_pandas_durations(folder, log):
    pandas = pytest.importorskip("pandas")
    pandas.DataFrame(log.columns | {"t": pandas.to_timedelta(_durations(log))}).to_csv(folder / "log.csv", index=False)
    return folder / "log.csv"


def _csv_polars_durations(folder, log):
    """As ISO 8601 has them; polars writes none to CSV as they are."""
    polars = pytest.importorskip("polars")
    frame = polars.DataFrame(log.columns | {"t": _durations(log)})
    frame.with_columns(polars.col("t").dt.to_string("iso")).write_csv(folder / "log.csv")
    return folder / "log.csv"


def _csv_polars_stamps(folder, log):
    polars = pytest.importorskip("polars")
    stamps = log.stamps.astype("datetime64[ns]")
    polars.DataFrame(log.columns | {"t": stamps}).write_csv(folder / "log.csv", separator=";", decimal_comma=True)
    return folder / "log.csv"


def _duckdb(folder, log, time, name):
    duckdb = pytest.importorskip("duckdb")
    with duckdb.connect() as connection:
        connection.register("log", _arrow(log))
        connection.sql(f"copy (select {time} as t, * exclude (t) from log) to '{folder / name}'")
    return folder / name


_STAMP = "make_timestamp_ns(cast(1700000000000000000 + round(1e9 * t) as bigint))"
_INTERVAL = "to_microseconds(cast(round(1e6 * t) as bigint))"


def _csv_duckdb_stamps(folder, log):
    return _duckdb(folder, log, _STAMP, "log.csv")


def _csv_duckdb_intervals(folder, log):
    return _duckdb(folder, log, _INTERVAL, "log.csv")


def _parquet_pandas_durations(folder, log):
    pandas = pytest.importorskip("pandas")
    pandas.DataFrame(log.columns | {"t": pandas.to_timedelta(_durations(log))}).to_parquet(folder / "log.parquet")
    return folder / "log.parquet"


def _parquet_lists(folder, log):
    """Beside structs and decimals lists, of which some are null, and texts."""
    import pyarrow
    from pyarrow import parquet

    goals = [dict(zip(JOINTS, row, strict=True)) for row in log.goals.tolist()]
    columns = {"t": pyarrow.array(log.time), "goal": pyarrow.array(goals)}
    columns |= {f"angle.{JOINTS[j]}": pyarrow.array(log.angles[:, j]).cast(pyarrow.decimal128(12, 6)) for j in ORDER}
    columns |= {"tags": pyarrow.array([["a"], None] * (len(log.time) // 2))}
    columns |= {"load": pyarrow.array([[1.0, 2.0], None] * (len(log.time) // 2))}
    parquet.write_table(pyarrow.table(columns), folder / "log.parquet")
    return folder / "log.parquet"


def _hdf5_compound(folder, log):
    h5py = pytest.importorskip("h5py")
    rows = np.empty(len(log.time), dtype=[(name, "f8") for name in log.columns])
    for name, values in log.columns.items():
        rows[name] = values
    with h5py.File(folder / "log.h5", "w") as file:
        file.create_dataset("log", data=rows, chunks=(16,), compression="gzip", shuffle=True)
    return folder / "log.h5"


def _lerobot_v3(folder, log):
    """The layout of version 3: several episodes a file, an index of them, and names as a plain list."""
    import pyarrow
    from pyarrow import parquet

    path = _lerobot(folder, log)
    old = path / "data" / "chunk-000" / "episode_000000.parquet"
    old.rename(old.with_name("file-000.parquet"))
    (path / "meta" / "episodes" / "chunk-000").mkdir(parents=True)
    index = {"episode_index": [0], "data/chunk_index": [0], "data/file_index": [0], "tasks": [["swing"]]}
    parquet.write_table(pyarrow.table(index), path / "meta" / "episodes" / "chunk-000" / "file-000.parquet")
    info = json.loads((path / "meta" / "info.json").read_text())
    for feature in info["features"].values():
        feature["names"] = feature["names"]["motors"]
    info |= {"codebase_version": "v3.0", "data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"}
    (path / "meta" / "info.json").write_text(json.dumps(info))
    return path


def _mcap_lz4(folder, log):
    return _mcap(folder, log, pytest.importorskip("lz4.frame").compress)


def _mcap_readings_first(folder, log):
    """The readings' topic begins before that of the commands."""
    early = np.concatenate([np.arange(-5, 0) / 100, log.time])
    goals = np.concatenate([np.full((5, 3), np.nan), log.goals])
    return _mcap(folder, Truth(early, goals, np.concatenate([np.full((5, 3), 0.7), log.angles])))


def _mcap_cut(folder, log):
    """Its logger died in the middle of a record, after what is compared."""
    more = Truth(np.arange(200) / 100, *(np.concatenate([v, np.full((80, 3), 0.1)]) for v in (log.goals, log.angles)))
    whole = _mcap(folder, more).read_bytes()
    (folder / "log.mcap").write_bytes(whole[: int(0.8 * len(whole)) - 3])
    return folder / "log.mcap"


def _mcap_two_definitions(folder, log):
    """Two publishers of one topic, whose definitions have their fields in another order."""
    pytest.importorskip("mcap_ros2")
    from mcap.writer import Writer
    from mcap_ros2._dynamic import serialize_dynamic

    fields = ["float64[] position", "float64[] velocity"]
    texts = [JOINT_STATE, JOINT_STATE.replace("\n".join(fields), "\n".join(fields[::-1]))]
    with (folder / "log.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        schemas = [writer.register_schema(_STATE, "ros2msg", text.encode()) for text in texts]
        pairs = product(("/joint_states", "/command"), enumerate(schemas))
        links = {(topic, k): writer.register_channel(topic, "cdr", schema) for topic, (k, schema) in pairs}
        encoders = [serialize_dynamic(_STATE, text)[_STATE] for text in texts]
        for k, (topic, stamp, names, values) in enumerate(_joint_states(log)):
            kind = (k // 2) % 2
            data = encoders[kind]({"name": names, "position": values, "velocity": [7.0] * 3})
            writer.add_message(links[topic, kind], stamp, data, stamp)
        writer.finish()
    return folder / "log.mcap"


def _mcap_protobuf(folder, log):
    """Messages of one's own kind: names and numbers as lists."""
    pytest.importorskip("mcap_protobuf")
    from google.protobuf.descriptor_pb2 import FieldDescriptorProto, FileDescriptorProto
    from google.protobuf.descriptor_pool import DescriptorPool
    from google.protobuf.message_factory import GetMessageClass
    from mcap_protobuf.writer import Writer

    file = FileDescriptorProto(name="arm.proto", package="own", syntax="proto3")
    kind = file.message_type.add(name="Arm")
    fields = (("joint_names", FieldDescriptorProto.TYPE_STRING), ("position", FieldDescriptorProto.TYPE_DOUBLE))
    for number, (name, type_) in enumerate(fields, 1):
        kind.field.add(name=name, number=number, type=type_, label=FieldDescriptorProto.LABEL_REPEATED)
    pool = DescriptorPool()
    pool.Add(file)
    message = GetMessageClass(pool.FindMessageTypeByName("own.Arm"))
    with (folder / "log.mcap").open("wb") as stream, Writer(stream) as writer:
        for topic, stamp, names, values in _joint_states(log):
            writer.write_message(topic, message(joint_names=names, position=values), stamp, stamp)
    return folder / "log.mcap"


def _bag_mcap(folder, log):
    return _bag_rosbags(folder, log, storage="MCAP")


def _bag_messages(folder, log):
    return _bag_rosbags(folder, log, mode="MESSAGE")


def _bag_file(folder, log):
    return _bag_rosbags(folder, log, mode="FILE")


FURTHER = {
    "CSV, words for what is absent": _csv_absent,
    "CSV, begun anew": _csv_two_starts,
    "CSV, readings before the first command": _csv_readings_first,
    "CSV, pandas with durations": _csv_pandas_durations,
    "CSV, polars with durations": _csv_polars_durations,
    "CSV, polars with time stamps and decimal commas": _csv_polars_stamps,
    "CSV, DuckDB with time stamps": _csv_duckdb_stamps,
    "CSV, DuckDB with intervals": _csv_duckdb_intervals,
    "Parquet, pandas with durations": _parquet_pandas_durations,
    "Parquet, decimals beside lists with nulls": _parquet_lists,
    "HDF5, compound types": _hdf5_compound,
    "LeRobot, version 3": _lerobot_v3,
    "MCAP, each message compressed by lz4": _mcap_lz4,
    "MCAP, readings before the first command": _mcap_readings_first,
    "MCAP, cut inside a record": _mcap_cut,
    "MCAP, one topic, two definitions": _mcap_two_definitions,
    "MCAP, protobuf of one's own": _mcap_protobuf,
    "rosbag2 folder, MCAP by rosbags": _bag_mcap,
    "rosbag2 folder, each message compressed": _bag_messages,
    "rosbag2 folder, compressed as a whole": _bag_file,
}
"""By the name that each has in the table of docs/recordings.md."""
