"""One log of a three-joint arm with known values, in the formats and variants in which people have logs.

Each writer gets a folder and the log, writes a file by the format's own library, and returns its path. The log's
columns bear the joints' names, in another order than the model's joints.
"""

import json
from dataclasses import dataclass

import numpy as np
import pytest

JOINTS = ("base", "shoulder", "elbow")
ORDER = (2, 0, 1)  # of the joints in the logs
MODEL = """
<mujoco><option timestep="0.005"/><default><geom contype="0" conaffinity="0"/></default><worldbody>
<body><joint name="base" axis="0 0 1" damping="1" armature=".1"/><geom size=".05"/>
<body pos=".1 0 0"><joint name="shoulder" axis="0 1 0" damping="1" armature=".1"/><geom size=".05"/>
<body pos=".1 0 0"><joint name="elbow" axis="0 1 0" damping="1" armature=".1"/><geom size=".05"/>
</body></body></body></worldbody>
<actuator><position name="m_base" joint="base" kp="40"/><position name="m_shoulder" joint="shoulder" kp="40"/>
<position name="m_elbow" joint="elbow" kp="40"/></actuator>
<sensor><jointpos name="q_base" joint="base"/><jointpos name="q_shoulder" joint="shoulder"/>
<jointpos name="q_elbow" joint="elbow"/></sensor></mujoco>
"""
START_NS = 1_700_000_000_000_000_000


@dataclass(frozen=True)
class Truth:
    """Times in s, and for each joint of the model its command and its reading."""

    time: np.ndarray
    goals: np.ndarray
    angles: np.ndarray

    @property
    def columns(self):
        """Flat columns by foreign names, in the order of the log."""
        named = {f"goal_{JOINTS[j]}": self.goals[:, j] for j in ORDER}
        return {"t": self.time} | named | {f"{JOINTS[j]}_position": self.angles[:, j] for j in ORDER}

    @property
    def stamps(self):
        """Times in ns since 1970."""
        return START_NS + np.round(1e9 * self.time).astype(np.int64)


def truth():
    """Three servos, swinging, sampled every 10 ms and rounded to what a text holds."""
    time = np.arange(120) / 100
    goals = np.stack([np.sin((2 + k) * time + k) for k in range(3)], axis=1).round(6)
    angles = np.stack([0.9 * np.sin((2 + k) * (time - 0.03) + k) + 0.05 * k for k in range(3)], axis=1).round(6)
    return Truth(time, goals, angles)


_TRAJECTORY = "trajectory_msgs/msg/JointTrajectory"
TRAJECTORY = f"""std_msgs/Header header
string[] joint_names
trajectory_msgs/JointTrajectoryPoint[] points
{"=" * 80}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{"=" * 80}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
{"=" * 80}
MSG: trajectory_msgs/JointTrajectoryPoint
float64[] positions
float64[] velocities
float64[] accelerations
float64[] effort
"""


def _text(folder, lines):
    (folder / "log.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return folder / "log.csv"


def _rows(columns, separator=",", cell=repr):
    return [separator.join(cell(float(v)) for v in row) for row in zip(*columns.values(), strict=True)]


def _csv(folder, log):
    return _text(folder, [",".join(log.columns), *_rows(log.columns)])


def _csv_semicolons(folder, log):
    rows = _rows(log.columns, ";", lambda v: f"{v:.6f}".replace(".", ","))
    return _text(folder, [";".join(log.columns), *rows])


def _csv_tabs(folder, log):
    return _text(folder, ["\t".join(log.columns), *_rows(log.columns, "\t")]).rename(folder / "log.tsv")


def _csv_savetxt(folder, log):
    table = np.stack(list(log.columns.values()), axis=1)
    np.savetxt(folder / "log.csv", table, delimiter=",", header=",".join(log.columns))
    return folder / "log.csv"


def _csv_units(folder, log):
    degrees = {n: v if n == "t" else np.degrees(v) for n, v in log.columns.items()} | {"t": 1000 * log.time}
    return _text(folder, ["# a log", ",".join(degrees), ",".join(["ms"] + ["deg"] * 6), *_rows(degrees)])


def _csv_units_in_names(folder, log):
    degrees = {n if n == "t" else f"{n} [deg]": v if n == "t" else np.degrees(v) for n, v in log.columns.items()}
    return _text(folder, [",".join(degrees), *_rows(degrees)])


def _csv_ns(folder, log):
    rows = [f"{s},{row.partition(',')[2]}" for s, row in zip(log.stamps, _rows(log.columns), strict=True)]
    return _text(folder, [",".join(["time", *list(log.columns)[1:]]), *rows])


def _csv_seconds_and_nanoseconds(folder, log):
    pairs = [f"{s // 10**9},{s % 10**9}" for s in log.stamps.tolist()]
    rows = [f"{p},{row.partition(',')[2]}" for p, row in zip(pairs, _rows(log.columns), strict=True)]
    return _text(folder, [",".join(["stamp.sec", "stamp.nanosec", *list(log.columns)[1:]]), *rows])


def _csv_iso(folder, log):
    stamps = [f"{stamp.astype('datetime64[ns]')}Z" for stamp in log.stamps]
    rows = [f"{s},{row.partition(',')[2]}" for s, row in zip(stamps, _rows(log.columns), strict=True)]
    return _text(folder, [",".join(log.columns), *rows])


def _csv_as_it_comes(folder, log):
    """A comma behind each row, columns of one name, a header repeated, a remark, and a row that was cut."""
    rows = [f"{row},x,y," for row in _rows(log.columns)]
    header = f"{','.join(log.columns)},state,state,"
    path = _text(folder, ["% written by a logger", header, *rows[:50], "# a remark", header, *rows[50:]])
    path.write_text(path.read_text() + rows[0][:40])
    return path


def _csv_pandas(folder, log):
    pytest.importorskip("pandas").DataFrame(log.columns).to_csv(folder / "log.csv")
    return folder / "log.csv"


def _csv_levels(folder, log):
    """Columns in two levels, the index with a name: a header of three lines."""
    pandas = pytest.importorskip("pandas")
    pairs = [(kind, JOINTS[j]) for kind in ("goal", "position") for j in ORDER]
    values = np.concatenate([log.goals[:, ORDER], log.angles[:, ORDER]], axis=1)
    frame = pandas.DataFrame(values, pandas.Index(log.time, name="time"), pandas.MultiIndex.from_tuples(pairs))
    frame.to_csv(folder / "log.csv")
    return folder / "log.csv"


def _csv_polars(folder, log):
    pytest.importorskip("polars").DataFrame(log.columns).write_csv(folder / "log.csv")
    return folder / "log.csv"


def _npz(folder, log):
    np.savez_compressed(folder / "log.npz", **log.columns)
    return folder / "log.npz"


def _npz_stamps(folder, log):
    np.savez(folder / "log.npz", **(log.columns | {"t": log.stamps.astype("datetime64[ns]")}))
    return folder / "log.npz"


def _npz_structured(folder, log):
    rows = np.empty(len(log.time), dtype=[(name, "f8") for name in log.columns] + [("label", "U3")])
    for name, values in log.columns.items():
        rows[name] = values
    np.savez(folder / "log.npz", log=rows)
    return folder / "log.npz"


def _arrow(log):
    import pyarrow

    return pyarrow.table(log.columns)


def _parquet(folder, log):
    from pyarrow import parquet

    parquet.write_table(_arrow(log), folder / "log.parquet", row_group_size=50)
    return folder / "log.parquet"


def _parquet_structs(folder, log):
    import pyarrow
    from pyarrow import parquet

    goals = [{JOINTS[j]: row[j] for j in ORDER} for row in log.goals.tolist()]
    angles = [{"position": {JOINTS[j]: row[j] for j in ORDER}} for row in log.angles.tolist()]
    parquet.write_table(pyarrow.table({"t": log.time, "goal": goals, "state": angles}), folder / "log.parquet")
    return folder / "log.parquet"


def _parquet_pandas(folder, log):
    pandas = pytest.importorskip("pandas")
    frame = pandas.DataFrame(dict(list(log.columns.items())[1:]), index=pandas.to_datetime(log.stamps, utc=True))
    frame.rename_axis("time").to_parquet(folder / "log.parquet")
    return folder / "log.parquet"


def _parquet_polars(folder, log):
    polars = pytest.importorskip("polars")
    frame = polars.DataFrame(log.columns | {"t": (1e9 * log.time).round().astype("timedelta64[ns]")})
    frame.write_parquet(folder / "log.parquet")
    return folder / "log.parquet"


def _parquet_duckdb(folder, log):
    duckdb = pytest.importorskip("duckdb")
    stamp = "make_timestamp_ns(cast(1700000000000000000 + round(1e9 * t) as bigint)) as t"
    with duckdb.connect() as connection:
        connection.register("log", _arrow(log))
        connection.sql(f"select * exclude (t), {stamp} from log").write_parquet(str(folder / "log.parquet"))
    return folder / "log.parquet"


def _feather(folder, log):
    from pyarrow import feather

    feather.write_feather(_arrow(log), folder / "log.feather")
    return folder / "log.feather"


def _feather_polars(folder, log):
    pytest.importorskip("polars").DataFrame(log.columns).write_ipc(folder / "log.arrow")
    return folder / "log.arrow"


def _hdf5(folder, log):
    h5py = pytest.importorskip("h5py")
    with h5py.File(folder / "log.h5", "w") as file:
        for name, values in log.columns.items():
            file[f"robot/{name}"] = values
    return folder / "log.h5"


def _hdf5_demonstrations(folder, log):
    """robomimic's layout; the second demonstration is something else."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(folder / "log.hdf5", "w") as file:
        for name, values in log.columns.items():
            file[f"data/demo_0/obs/{name}"] = values
            file[f"data/demo_1/obs/{name}"] = np.zeros(9)
    return folder / "log.hdf5"


def _hdf5_matlab(folder, log):
    h5py = pytest.importorskip("h5py")
    with h5py.File(folder / "log.mat", "w") as file:
        for name, values in log.columns.items():
            file[name] = values[None]
            file[name].attrs["MATLAB_class"] = np.bytes_("double")
    return folder / "log.mat"


def _lerobot(folder, log):
    """The layout of version 2.1, names in `info.json`."""
    import pyarrow
    from pyarrow import parquet

    (folder / "set" / "meta").mkdir(parents=True)
    (folder / "set" / "data" / "chunk-000").mkdir(parents=True)
    lists = {
        n: list(v[:, ORDER].astype(np.float32)) for n, v in (("action", log.goals), ("observation.state", log.angles))
    }
    columns = lists | {"timestamp": log.time.astype(np.float32), "episode_index": np.zeros(len(log.time), np.int64)}
    parquet.write_table(pyarrow.table(columns), folder / "set" / "data" / "chunk-000" / "episode_000000.parquet")
    feature = {"dtype": "float32", "shape": [3], "names": {"motors": [f"{JOINTS[j]}.pos" for j in ORDER]}}
    info = {"codebase_version": "v2.1", "total_episodes": 1, "fps": 100, "chunks_size": 1000}
    info |= {"data_path": "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet"}
    info |= {"features": {"action": feature, "observation.state": feature}}
    (folder / "set" / "meta" / "info.json").write_text(json.dumps(info))
    return folder / "set"


def _joint_states(log):
    """Topic, time in ns, and what a JointState holds; readings turn their order round, and come first."""
    for stamp, goals, angles in zip(log.stamps.tolist(), log.goals.tolist(), log.angles.tolist(), strict=True):
        for topic, values in (("/joint_states", angles), ("/command", goals)):
            order = ORDER[::-1] if topic == "/joint_states" and (stamp // 10_000_000) % 2 else ORDER
            yield topic, stamp, [JOINTS[j] for j in order], [values[j] for j in order]


def _mcap(folder, log, pack=None, name="log.mcap", stamped=None, booted=()):
    """Headers have seconds alone, or whole stamps: those of the topics `stamped`, of `booted` since a start, else 0."""
    pytest.importorskip("mcap_ros2")
    from mcap.writer import Writer
    from mcap_ros2._dynamic import serialize_dynamic

    from tests.recordings.readers.forms import JOINT_STATE

    kind = "sensor_msgs/msg/JointState"
    encode = serialize_dynamic(kind, JOINT_STATE)[kind]
    with (folder / name).open("wb") as stream:
        writer = Writer(stream, chunk_size=4096)
        writer.start(profile="ros2", library="test")
        schema = writer.register_schema(kind, "ros2msg", JOINT_STATE.encode())
        channels = {topic: writer.register_channel(topic, "cdr", schema) for topic in ("/joint_states", "/command")}
        for topic, stamp, names, values in _joint_states(log):
            if np.isnan(values).any():
                continue
            when = {"sec": stamp // 10**9}
            if stamped is not None:
                since = stamp - (START_NS - 5_000_000_000 if topic in booted else 0) if topic in stamped else 0
                when = {"sec": since // 10**9, "nanosec": since % 10**9}
            data = encode({"name": names, "position": values, "header": {"stamp": when}})
            writer.add_message(channels[topic], stamp, pack(data) if pack else data, stamp)
        writer.finish()
    return folder / name


def _mcap_json(folder, log):
    pytest.importorskip("mcap")
    from mcap.writer import Writer

    with (folder / "log.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start()
        channels = {topic: writer.register_channel(topic, "json", 0) for topic in ("/joint_states", "/command")}
        for topic, stamp, names, values in _joint_states(log):
            joints = [{"name": n, "position": v} for n, v in zip(names, values, strict=True)]
            writer.add_message(channels[topic], stamp, json.dumps({"joints": joints}).encode(), stamp)
        writer.finish()
    return folder / "log.mcap"


def _mcap_trajectories(folder, log):
    """Commands as trajectories of one point, with `joint_names`."""
    pytest.importorskip("mcap_ros2")
    from mcap.writer import Writer
    from mcap_ros2._dynamic import serialize_dynamic

    from tests.recordings.readers.forms import JOINT_STATE

    kinds = {"/joint_states": ("sensor_msgs/msg/JointState", JOINT_STATE), "/command": (_TRAJECTORY, TRAJECTORY)}
    with (folder / "log.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        encoders, channels = {}, {}
        for topic, (kind, text) in kinds.items():
            encoders[topic] = serialize_dynamic(kind, text)[kind]
            channels[topic] = writer.register_channel(
                topic, "cdr", writer.register_schema(kind, "ros2msg", text.encode())
            )
        for topic, stamp, names, values in _joint_states(log):
            goal = {"joint_names": names, "points": [{"positions": values}]}
            data = encoders[topic]({"name": names, "position": values} if topic == "/joint_states" else goal)
            writer.add_message(channels[topic], stamp, data, stamp)
        writer.finish()
    return folder / "log.mcap"


def _mcap_foxglove(folder, log):
    pytest.importorskip("mcap_protobuf")
    foxglove = pytest.importorskip("foxglove")
    from foxglove.channels import JointStatesChannel
    from foxglove.messages import JointState, JointStates

    context = foxglove.Context()
    with foxglove.open_mcap(folder / "log.mcap", context=context):
        channels = {topic: JointStatesChannel(topic, context=context) for topic in ("/joint_states", "/command")}
        for topic, stamp, names, values in _joint_states(log):
            joints = [JointState(name=n, position=v) for n, v in zip(names, values, strict=True)]
            channels[topic].log(JointStates(joints=joints), log_time=stamp)
    return folder / "log.mcap"


def _mcap_packed_messages(folder, log):
    return _mcap(folder, log, pytest.importorskip("zstandard").ZstdCompressor().compress)


def _mcap_packed_file(folder, log):
    whole = _mcap(folder, log).read_bytes()
    (folder / "log.mcap.zstd").write_bytes(pytest.importorskip("zstandard").ZstdCompressor().compress(whole))
    return folder / "log.mcap.zstd"


def _bag_folder(folder, log):
    (folder / "run").mkdir()
    _mcap(folder / "run", log, name="run_0.mcap")
    return folder / "run"


def _bag_rosbags(folder, log, version=2, storage="SQLITE3", mode="NONE"):
    pytest.importorskip("rosbags.highlevel")
    from rosbags.rosbag1 import Writer as Writer1
    from rosbags.rosbag2 import CompressionFormat, CompressionMode, StoragePlugin
    from rosbags.rosbag2 import Writer as Writer2
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE if version == 2 else Stores.ROS1_NOETIC)
    kind, types = "sensor_msgs/msg/JointState", store.types
    path = folder / ("run" if version == 2 else "log.bag")
    writer = Writer1(path) if version == 1 else Writer2(path, version=9, storage_plugin=StoragePlugin[storage])
    if isinstance(writer, Writer2) and mode != "NONE":
        writer.set_compression(CompressionMode[mode], CompressionFormat.ZSTD)
    empty = np.empty(0)
    with writer:
        links = {topic: writer.add_connection(topic, kind, typestore=store) for topic in ("/joint_states", "/command")}
        for topic, stamp, names, values in _joint_states(log):
            time = types["builtin_interfaces/msg/Time"](stamp // 10**9, stamp % 10**9)
            header = types["std_msgs/msg/Header"](**({} if version == 2 else {"seq": 0}), stamp=time, frame_id="")
            message = types[kind](header, names, np.array(values), empty, empty)
            data = (store.serialize_cdr if version == 2 else store.serialize_ros1)(message, kind)
            writer.write(links[topic], stamp, data)
    return path


def _bag_ros1(folder, log):
    return _bag_rosbags(folder, log, 1)


def _bag_bare_numbers(folder, log):
    """Commands as bare numbers; their order stands among the controller's parameters, and readings have another."""
    pytest.importorskip("rosbags.highlevel")
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.ROS2_HUMBLE)
    kinds = {
        "/arm_controller/commands": "std_msgs/msg/Float64MultiArray",
        "/joint_states": "sensor_msgs/msg/JointState",
    }
    kinds["/parameter_events"] = "rcl_interfaces/msg/ParameterEvent"

    def made(kind, *fields):
        return store.types[kind](*fields)

    def time(stamp):
        return made("builtin_interfaces/msg/Time", stamp // 10**9, stamp % 10**9)

    empty, names = np.empty(0), [JOINTS[j] for j in ORDER]
    value = made("rcl_interfaces/msg/ParameterValue", 9, False, 0, 0.0, "", *[empty.astype(t) for t in "Bbqd"], names)
    joints = made("rcl_interfaces/msg/Parameter", "joints", value)
    layout = made("std_msgs/msg/MultiArrayLayout", [], 0)
    with Writer(folder / "run", version=9, storage_plugin=StoragePlugin.SQLITE3) as writer:
        links = {topic: writer.add_connection(topic, kind, typestore=store) for topic, kind in kinds.items()}

        def write(topic, stamp, *fields):
            message = made(kinds[topic], *fields)
            writer.write(links[topic], stamp, store.serialize_cdr(message, kinds[topic]))

        begin = int(log.stamps[0])
        write("/parameter_events", begin, time(begin), "/arm_controller", [joints], [], [])
        for stamp, goals, angles in zip(log.stamps.tolist(), log.goals, log.angles, strict=True):
            header = made("std_msgs/msg/Header", time(stamp), "")
            write("/joint_states", stamp, header, list(JOINTS), angles, empty, empty)
            write("/arm_controller/commands", stamp, layout, goals[list(ORDER)])
    return folder / "run"


def _hdf5_aloha(folder, log):
    """ALOHA's layout: lists in the model's order without names, no clock, pictures, wheels."""
    h5py = pytest.importorskip("h5py")
    rows = len(log.time)
    with h5py.File(folder / "episode_0.hdf5", "w") as file:
        file.attrs["sim"] = False
        file["action"], file["wheel_action"], file["compress_len"] = log.goals, np.zeros((rows, 2)), np.ones((1, rows))
        file["observations/qpos"], file["observations/qvel"] = log.angles, np.gradient(log.angles, 0.01, axis=0)
        file["observations/effort"] = np.zeros((rows, 3))
        file["observations/images/cam_high"] = np.zeros((rows, 2, 2, 3), np.uint8)
    return folder / "episode_0.hdf5"


VARIANTS = {
    "CSV": _csv,
    "CSV, semicolons and decimal commas": _csv_semicolons,
    "TSV": _csv_tabs,
    "CSV, numpy.savetxt": _csv_savetxt,
    "CSV, a line of units": _csv_units,
    "CSV, units in the names": _csv_units_in_names,
    "CSV, time in ns": _csv_ns,
    "CSV, seconds and nanoseconds": _csv_seconds_and_nanoseconds,
    "CSV, ISO time stamps": _csv_iso,
    "CSV, as it comes": _csv_as_it_comes,
    "CSV, pandas": _csv_pandas,
    "CSV, pandas with columns in levels": _csv_levels,
    "CSV, polars": _csv_polars,
    "NPZ": _npz,
    "NPZ, datetime64": _npz_stamps,
    "NPZ, structured array": _npz_structured,
    "Parquet": _parquet,
    "Parquet, structs": _parquet_structs,
    "Parquet, pandas with a time index": _parquet_pandas,
    "Parquet, polars with durations": _parquet_polars,
    "Parquet, DuckDB with time stamps": _parquet_duckdb,
    "Feather": _feather,
    "Arrow IPC, polars": _feather_polars,
    "HDF5": _hdf5,
    "HDF5, robomimic": _hdf5_demonstrations,
    "HDF5, ALOHA": _hdf5_aloha,
    "HDF5, MATLAB v7.3": _hdf5_matlab,
    "LeRobot": _lerobot,
    "MCAP, ROS 2": _mcap,
    "MCAP, ROS 2 trajectories as commands": _mcap_trajectories,
    "MCAP, JSON": _mcap_json,
    "MCAP, Foxglove protobuf": _mcap_foxglove,
    "MCAP, each message compressed": _mcap_packed_messages,
    "MCAP, compressed as a whole": _mcap_packed_file,
    "rosbag2 folder, MCAP": _bag_folder,
    "rosbag2 folder, SQLite": _bag_rosbags,
    "rosbag2, commands of bare numbers": _bag_bare_numbers,
    "ROS 1 bag": _bag_ros1,
}
"""By the name that each has in the table of docs/recordings.md."""
TO_BE_CHECKED = {
    "HDF5, ALOHA": "by its order: check",
    "rosbag2, commands of bare numbers": "by the list of names in /parameter_events, /arm_controller.joints: check",
}
"""What `--init` says of variants that do not name each column."""
WITHOUT_CLOCK = ("HDF5, ALOHA",)
