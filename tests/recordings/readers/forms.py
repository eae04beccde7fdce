"""One log in the five forms in which logs are read, each with its manifest."""

import json

import numpy as np
import pyarrow
from pyarrow import parquet

from estexp_jax.recordings.write import write_csv

FORMS = ("csv", "npz", "parquet", "lerobot", "mcap")
COLUMNS = {
    "csv": {"ctrl.servo": "goal", "sensor.angle": "position"},
    "npz": {"ctrl.servo": "goal", "sensor.angle": "position"},
    "parquet": {"ctrl.servo": "goal", "sensor.angle": "position"},
    "lerobot": {
        "time": "timestamp",
        "ctrl.servo": {"column": "action", "index": 1},
        "sensor.angle": "observation.state.elbow.pos",
    },
    "mcap": {"ctrl.servo": "/goal.position[0]", "sensor.angle": "/joint_states.position[elbow]"},
}
"""What the manifest of each form says of its columns."""

JOINT_STATE = f"""std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{"=" * 80}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
"""


class Schema:
    """Of a channel, as an MCAP file has it."""

    encoding = "ros2msg"

    def __init__(self, name, text):
        self.name, self.data = name, text.encode()


def write_form(form, folder, logs, model, roles=("train", "train", "test")):
    """Write logs, each (time, goal, position) with NaN where there is no sample, in one form; the manifest's path."""
    folder.mkdir()
    lines = [f"model = {json.dumps(str(model))}", "[columns]"]
    for ours, source in COLUMNS[form].items():
        text = json.dumps(source) if isinstance(source, str) else f'{{ column = "{source["column"]}", index = 1 }}'
        lines.append(f'"{ours}" = {text}')
    write = {"csv": _csv, "npz": _npz, "parquet": _parquet, "mcap": write_mcap}.get(form)
    for index, (log, role) in enumerate(zip(logs, roles, strict=False)):
        name = f"log_{index}.{form}" if write else "set"
        lines += ["[[recording]]", f'file = "{name}"', f'role = "{role}"']
        lines += [] if write else [f"episode = {index}"]
        if write:
            write(folder / name, *log)
    if not write:
        write_lerobot(folder / "set", logs)
    (folder / "recordings.toml").write_text("\n".join(lines) + "\n")
    return folder / "recordings.toml"


def _csv(path, time, goal, position):
    write_csv(path, {"time": time, "goal": goal, "position": position})


def _npz(path, time, goal, position):
    np.savez_compressed(path, time=time, goal=goal, position=position)


def _parquet(path, time, goal, position):
    parquet.write_table(pyarrow.table({"time": time, "goal": goal, "position": position}), path)


def write_lerobot(folder, logs, version="v3.0"):
    """A data set with an episode a log: the first two in one file, as the format packs them."""
    for kind in ("meta/episodes/chunk-000", "data/chunk-000", "data/chunk-001"):
        (folder / kind).mkdir(parents=True)
    files = {(0, 0): range(min(2, len(logs))), (1, 0): range(2, len(logs))}
    places = [(chunk, file, episode) for (chunk, file), held in files.items() for episode in held]
    for (chunk, file), held in files.items():
        if held:
            table = pyarrow.concat_tables([_episode(index, *logs[index]) for index in held])
            parquet.write_table(
                table, folder / f"data/chunk-{chunk:03d}/file-{file:03d}.parquet", row_group_size=len(table) // 3
            )
    table = {"episode_index": [p[2] for p in places], "data/chunk_index": [p[0] for p in places]}
    table |= {"data/file_index": [p[1] for p in places], "tasks": [["swing"]] * len(places)}
    parquet.write_table(pyarrow.table(table), folder / "meta/episodes/chunk-000/file-000.parquet")
    names = ["shoulder.pos", "elbow.pos"]
    feature = {"dtype": "float32", "shape": [2], "names": names}
    info = {"codebase_version": version, "total_episodes": len(logs), "fps": 100, "chunks_size": 1000}
    info |= {"data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"}
    info |= {"features": {"action": feature, "observation.state": feature}}
    (folder / "meta" / "info.json").write_text(json.dumps(info))


def _episode(index, time, goal, position):
    rows = len(time)
    two = [np.stack([np.zeros(rows), values], axis=1).astype(np.float32) for values in (goal, position)]
    lists = [pyarrow.FixedSizeListArray.from_arrays(pyarrow.array(values.ravel()), 2) for values in two]
    columns = {"action": lists[0], "observation.state": lists[1], "timestamp": time.astype(np.float32)}
    columns |= {"frame_index": np.arange(rows), "episode_index": np.full(rows, index), "index": np.arange(rows)}
    picture = pyarrow.array([{"bytes": b"x", "path": "a.png"}] * rows)
    return pyarrow.table(columns | {"observation.image": picture})


def write_mcap(path, time, goal, position, stamp_offset_s=0.0):
    """Commands in JSON and joint states in CDR, each where it has a sample; joint states turn their order round."""
    from mcap.writer import CompressionType, Writer
    from mcap_ros2._dynamic import serialize_dynamic

    encode = serialize_dynamic("sensor_msgs/msg/JointState", JOINT_STATE)["sensor_msgs/msg/JointState"]
    with path.open("wb") as stream:
        writer = Writer(stream, chunk_size=4096, compression=CompressionType.ZSTD)
        writer.start(profile="ros2", library="test")
        schema = writer.register_schema("sensor_msgs/msg/JointState", "ros2msg", JOINT_STATE.encode())
        states = writer.register_channel("/joint_states", "cdr", schema)
        goals = writer.register_channel("/goal", "json", 0)
        picture = writer.register_channel("/camera", "protobuf", 0)
        for row, stamp in enumerate(np.round(1e9 * time).astype(np.int64).tolist()):
            log_time = 1_700_000_000_000_000_000 + stamp
            stamps = {"log_time": log_time, "publish_time": log_time - 1000}
            if np.isfinite(goal[row]):
                writer.add_message(goals, data=json.dumps({"position": [goal[row]]}).encode(), **stamps)
            if np.isfinite(position[row]):
                pair = [("shoulder", 0.5), ("elbow", position[row])][:: -1 if row % 2 else 1]
                header = {"stamp": {"sec": 1_700_000_000, "nanosec": int(stamp % 10**9)}, "frame_id": "base"}
                names, values = [name for name, _ in pair], [value for _, value in pair]
                message = {"header": header, "name": names, "position": values, "velocity": [], "effort": []}
                writer.add_message(states, data=encode(message), **stamps)
            if row % 50 == 0:
                writer.add_message(picture, data=b"\x00" * 100, **stamps)
        writer.finish()
