"""Logs of a leg, an arm and a biped in other recorders' formats, names, orders, signs and units.

Each writer gets a folder, times (rows,) in s, and goals, angles and speeds (rows, joints), writes a log, and returns
its path. `LOGS` says which column each of ours is in.
"""

import json
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import mujoco
import numpy as np
import pytest

from estexp_jax.recordings.write import write_csv
from tests.recordings.readers.forms import JOINT_STATE

LEG = ("hip", "thigh", "knee")
ARM = ("shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3")
BIPED = ("left_hip", "left_knee", "right_hip", "right_knee")
_SHORT = dict(zip(BIPED, ("LHip", "LKnee", "RHip", "RKnee"), strict=True))
START_NS = 1_700_000_000_000_000_000
_ARRAY = f"""std_msgs/MultiArrayLayout layout
float64[] data
{"=" * 80}
MSG: std_msgs/MultiArrayLayout
std_msgs/MultiArrayDimension[] dim
uint32 data_offset
{"=" * 80}
MSG: std_msgs/MultiArrayDimension
string label
uint32 size
uint32 stride
"""


def model_of(joints, damping=1.2):
    """MJCF of a chain of servos with these joints."""
    bodies = ""
    for k, joint in enumerate(joints):
        axis = "0 0 1" if k == 0 and joints is ARM else "0 1 0"
        bodies += f'<body pos=".15 0 0"><joint name="{joint}_joint" axis="{axis}" damping="{damping}" armature=".05"/>'
        bodies += f'<geom type="capsule" fromto="0 0 0 .15 0 0" size=".02" mass="{0.5 - 0.05 * k}"/>'
    bodies += "</body>" * len(joints)
    servos = "".join(f'<position name="m_{j}" joint="{j}_joint" kp="{60 + 20 * k}"/>' for k, j in enumerate(joints))
    sensors = "".join(f'<jointpos name="q_{j}" joint="{j}_joint"/>' for j in joints)
    sensors += "".join(f'<jointvel name="w_{j}" joint="{j}_joint"/>' for j in joints)
    head = '<option timestep="0.005"/><default><geom contype="0" conaffinity="0"/></default>'
    return (
        f"<mujoco>{head}<worldbody>{bodies}</worldbody><actuator>{servos}</actuator><sensor>{sensors}</sensor></mujoco>"
    )


@cache
def motion(joints):
    """Times, goals, angles and speeds of a robot that is damped more than its model."""
    model = mujoco.MjModel.from_xml_string(model_of(joints, 1.6))
    data, time, each = mujoco.MjData(model), np.arange(400) * 0.01, np.arange(len(joints))
    goals = 0.6 * np.sin((1.5 + 0.55 * each) * time[:, None] + each) + 0.2 * np.sin((3.1 + 0.3 * each) * time[:, None])
    rows = []
    for goal in goals:
        rows.append((data.qpos.copy(), data.qvel.copy()))
        data.ctrl[:] = goal
        mujoco.mj_step(model, data, 2)
    return time, goals, *(np.array(each) for each in zip(*rows, strict=True))


def _numbers(folder, time, goals, angles, speeds):
    """Names that only count, of more quantities than are wanted."""
    columns = {"timestamp": time + 1234.5}
    for name, values in (
        ("target_q", goals),
        ("actual_q", angles),
        ("actual_qd", speeds),
        ("actual_current", 3 * goals),
    ):
        columns |= {f"{name}_{k}": values[:, k] for k in range(values.shape[1])}
    write_csv(folder / "log.csv", columns)
    return folder / "log.csv"


def _glued(folder, time, goals, angles, speeds):
    """Sides as a letter glued to the joint's name, commands in another order than readings; ms."""
    columns = {"TimeMs": 1000.0 * time}
    columns |= {f"{_SHORT[BIPED[k]]}Pos": angles[:, k] for k in (3, 1, 2, 0)}
    write_csv(folder / "log.csv", columns | {f"{_SHORT[BIPED[k]]}Cmd": goals[:, k] for k in (0, 2, 1, 3)})
    return folder / "log.csv"


def _bare(folder, time, goals, angles, speeds):
    """Joint states in the alphabet's order, as a broadcaster sends them; commands as numbers without names."""
    pytest.importorskip("mcap_ros2")
    from mcap.writer import Writer
    from mcap_ros2._dynamic import serialize_dynamic

    kinds = {"/joint_states": ("sensor_msgs/msg/JointState", JOINT_STATE)}
    kinds["/position_controller/commands"] = ("std_msgs/msg/Float64MultiArray", _ARRAY)
    order = np.argsort([f"{joint}_joint" for joint in ARM])
    with (folder / "log.mcap").open("wb") as stream:
        writer = Writer(stream)
        writer.start(profile="ros2", library="test")
        channels, encoders = {}, {}
        for topic, (kind, text) in kinds.items():
            schema = writer.register_schema(kind, "ros2msg", text.encode())
            channels[topic], encoders[topic] = (
                writer.register_channel(topic, "cdr", schema),
                serialize_dynamic(kind, text),
            )
        for row, stamp in enumerate((START_NS + np.round(1e9 * time).astype(int)).tolist()):
            state = {"name": [f"{ARM[k]}_joint" for k in order], "position": angles[row, order].tolist()}
            state |= {"velocity": speeds[row, order].tolist()}
            for (topic, (kind, _)), message in zip(kinds.items(), (state, {"data": goals[row].tolist()}), strict=True):
                writer.add_message(channels[topic], stamp, encoders[topic][kind](message), stamp)
        writer.finish()
    return folder / "log.mcap"


def _lerobot(folder, time, goals, angles, speeds):
    """Version 3, the right side first."""
    import pyarrow
    from pyarrow import parquet

    for place in ("data/chunk-000", "meta/episodes/chunk-000"):
        (folder / "set" / place).mkdir(parents=True)
    order, rows = [2, 3, 0, 1], len(time)
    lists = {"action": goals, "observation.state": angles}
    columns: dict[str, Any] = {name: list(values[:, order].astype(np.float32)) for name, values in lists.items()}
    columns |= {"timestamp": time.astype(np.float32), "episode_index": np.zeros(rows, int)}
    parquet.write_table(pyarrow.table(columns), folder / "set/data/chunk-000/file-000.parquet")
    index = {"episode_index": [0], "data/chunk_index": [0], "data/file_index": [0]}
    parquet.write_table(pyarrow.table(index), folder / "set/meta/episodes/chunk-000/file-000.parquet")
    feature = {"dtype": "float32", "shape": [4], "names": [f"{BIPED[k]}.pos" for k in order]}
    info = {"codebase_version": "v3.0", "total_episodes": 1, "fps": 100, "chunks_size": 1000}
    info |= {"data_path": "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet"}
    info |= {"features": dict.fromkeys(lists, feature)}
    (folder / "set/meta/info.json").write_text(json.dumps(info))
    return folder / "set"


def _degrees(folder, time, goals, angles, speeds):
    """Degrees and degrees a second, by the names' ends; durations as the clock."""
    import pyarrow
    from pyarrow import parquet

    columns: dict[str, Any] = {"stamp": np.round(1e9 * time).astype(np.int64).astype("timedelta64[ns]")}
    for k in (5, 3, 0, 1, 4, 2):
        columns |= {f"{ARM[k]}_meas_deg": np.degrees(angles[:, k]), f"{ARM[k]}_cmd_deg": np.degrees(goals[:, k])}
        columns |= {f"{ARM[k]}_speed_deg_s": np.degrees(speeds[:, k])}
    parquet.write_table(pyarrow.table(columns), folder / "log.parquet")
    return folder / "log.parquet"


def _groups(folder, time, goals, angles, speeds):
    """A group for each joint, in another order than the model's."""
    h5py = pytest.importorskip("h5py")
    with h5py.File(folder / "log.h5", "w") as file:
        file["time"] = time
        for k in (2, 0, 1):
            kinds = (("command", goals), ("position", angles), ("velocity", speeds))
            for name, values in kinds:
                file[f"robot/{LEG[k]}/{name}"] = values[:, k]
            file[f"robot/{LEG[k]}/temperature"] = 30.0 + 0.0 * time
    return folder / "log.h5"


def _turned(folder, time, goals, angles, speeds):
    """One joint's reading has the other sign; joints are objects in a list, in turned order."""
    pytest.importorskip("mcap_protobuf")
    foxglove = pytest.importorskip("foxglove")
    from foxglove.channels import JointStatesChannel
    from foxglove.messages import JointState, JointStates

    context = foxglove.Context()
    with foxglove.open_mcap(folder / "log.mcap", context=context):
        channels = {topic: JointStatesChannel(topic, context=context) for topic in ("/state", "/cmd")}
        for row, stamp in enumerate((START_NS + np.round(1e9 * time).astype(int)).tolist()):
            for topic, values, order in (
                ("/state", angles[row] * (1, 1, -1), (2, 1, 0)),
                ("/cmd", goals[row], (0, 1, 2)),
            ):
                joints = [JointState(name=LEG[k], position=values[k]) for k in order]
                channels[topic].log(JointStates(joints=joints), log_time=stamp)
    return folder / "log.mcap"


def _matrices(folder, time, goals, angles, speeds):
    """Lists without names."""
    np.savez(folder / "log.npz", t=time, joint_pos=angles, joint_cmd=goals, joint_vel=speeds)
    return folder / "log.npz"


class ForeignLog(NamedTuple):
    """A log, and what is right.

    Attributes:
        joints: of its robot.
        write: writes it.
        command, position, speed: our column's source, by the joint and its number; a place in a list after a `|`.
        said: what `--init` has to say.
    """

    joints: tuple[str, ...]
    write: Callable[..., Any]
    command: Callable[[str, int], str]
    position: Callable[[str, int], str]
    speed: Callable[[str, int], str] | None = None
    said: str = ""


LOGS = {
    "CSV, names that count": ForeignLog(
        *(ARM, _numbers, lambda j, k: f"target_q_{k}", lambda j, k: f"actual_q_{k}", lambda j, k: f"actual_qd_{k}"),
        said="by its order: check this",
    ),
    "CSV, sides as letters": ForeignLog(
        BIPED, _glued, lambda j, k: f"{_SHORT[j]}Cmd", lambda j, k: f"{_SHORT[j]}Pos", said='unit = "ms"'
    ),
    "MCAP, commands without names": ForeignLog(
        *(ARM, _bare, lambda j, k: f"/position_controller/commands.data[{k}]"),
        *(lambda j, k: f"/joint_states.position[{j}_joint]", lambda j, k: f"/joint_states.velocity[{j}_joint]"),
        "by its order: check this",
    ),
    "LeRobot, the right side first": ForeignLog(
        BIPED, _lerobot, lambda j, k: f"action.{j}.pos", lambda j, k: f"observation.state.{j}.pos"
    ),
    "Parquet, degrees": ForeignLog(
        *(ARM, _degrees, lambda j, k: f"{j}_cmd_deg", lambda j, k: f"{j}_meas_deg", lambda j, k: f"{j}_speed_deg_s"),
        'unit = "deg/s"',
    ),
    "HDF5, a group for each joint": ForeignLog(
        *(LEG, _groups, lambda j, k: f"robot/{j}/command", lambda j, k: f"robot/{j}/position"),
        lambda j, k: f"robot/{j}/velocity",
    ),
    "MCAP, a sign": ForeignLog(
        *(LEG, _turned, lambda j, k: f"/cmd.joints[{j}].position", lambda j, k: f"/state.joints[{j}].position"),
        said="scale = -1.0 for sensor.q_knee",
    ),
    "NPZ, lists without names": ForeignLog(
        *(LEG, _matrices, lambda j, k: f"joint_cmd|{k}", lambda j, k: f"joint_pos|{k}", lambda j, k: f"joint_vel|{k}"),
        "by its order: check this",
    ),
}
