"""How fast logs are read, beside each format's own library, side by side: `python experiments/speed/reading.py`.

Two logs of fourteen joints are made in a temporary folder: an MCAP log of ROS 2 joint states, commands and a picture
now and then, and a Parquet file. Each is read for all positions and commands. The library of the format goes over the
same topics and decodes each message, or over all batches of the same columns, and keeps nothing; pyarrow and pandas are
also asked for whole columns.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from statistics import median
from time import process_time

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[2]))

JOINTS = tuple(f"joint_{index}" for index in range(14))
STATES, COMMANDS, PICTURES = "/joint_states", "/commands", "/camera"
START_NS = 1_700_000_000_000_000_000
DEFINITION = f"""std_msgs/Header header
string[] name
float64[] position
float64[] velocity
float64[] effort
{"=" * 80}
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
{"=" * 80}
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""
READERS = (
    *("mcap/estexp", "mcap/mcap + mcap-ros2-support"),
    *("parquet/estexp", "parquet/pyarrow, batches", "parquet/pyarrow, columns", "parquet/pandas"),
)


def write_mcap(path: Path, megabytes: float) -> None:
    """A log of about this size: 500 states and 250 commands a second, pictures of 50 kB ten times a second."""
    from mcap.writer import CompressionType, Writer
    from mcap_ros2._dynamic import serialize_dynamic

    kind = "sensor_msgs/msg/JointState"
    serialize = serialize_dynamic(kind, DEFINITION)[kind]
    random = np.random.default_rng(0)
    with path.open("wb") as stream:
        writer = Writer(stream, compression=CompressionType.ZSTD)
        writer.start(profile="ros2")
        schema = writer.register_schema(kind, "ros2msg", DEFINITION.encode())
        states, commands = (writer.register_channel(topic, "cdr", schema) for topic in (STATES, COMMANDS))
        picture = writer.register_channel(PICTURES, "png", 0)
        for row in range(10**9):
            time = START_NS + row * 2_000_000
            header = {"stamp": {"sec": time // 10**9, "nanosec": time % 10**9}, "frame_id": "base"}
            values = np.sin(1e-3 * row + np.arange(len(JOINTS))) + 1e-4 * random.standard_normal(len(JOINTS))
            lists = {"name": list(JOINTS), "position": values.tolist(), "velocity": values.tolist(), "effort": []}
            data = serialize({"header": header, **lists})
            writer.add_message(states, time, data, time)
            if row % 2 == 0:
                writer.add_message(commands, time, data, time)
            if row % 50 == 0:
                writer.add_message(picture, time, random.bytes(50_000), time)
                if stream.tell() > 1e6 * megabytes:
                    break
        writer.finish()


def write_parquet(path: Path, rows: int) -> None:
    """A log of this many rows, with commands, positions and speeds of each joint."""
    import pyarrow
    from pyarrow import parquet

    names = [f"{kind}_{joint}" for kind in ("goal", "position", "velocity") for joint in JOINTS]
    schema = pyarrow.schema([("time", pyarrow.float64()), *((name, pyarrow.float64()) for name in names)])
    with parquet.ParquetWriter(path, schema) as writer:
        for first in range(0, rows, 250_000):
            time = np.arange(first, min(first + 250_000, rows)) * 1e-3
            columns = {name: np.sin(time + k).round(4) for k, name in enumerate(names)}
            writer.write_table(pyarrow.table({"time": time, **columns}, schema=schema))


def read(reader: str, path: Path) -> None:
    """Read a log in one of the ways that `READERS` lists."""
    from estexp_jax.recordings.readers.read import read_table
    from estexp_jax.recordings.table import Selection

    columns = ["time", *(f"{kind}_{joint}" for kind in ("goal", "position") for joint in JOINTS[:3])]
    if reader == "mcap/estexp":
        wanted = frozenset(f"{topic}.position[{joint}]" for topic in (STATES, COMMANDS) for joint in JOINTS)
        assert len(read_table(path, Selection(wanted=wanted)).columns) == len(wanted) + 1
    elif reader == "mcap/mcap + mcap-ros2-support":
        from mcap.reader import make_reader
        from mcap_ros2.decoder import DecoderFactory

        with path.open("rb") as stream:
            decoded = make_reader(stream, decoder_factories=[DecoderFactory()])
            for _ in decoded.iter_decoded_messages(topics=[STATES, COMMANDS]):
                pass
    elif reader == "parquet/estexp":
        assert len(read_table(path, Selection(wanted=frozenset(columns))).columns) == len(columns)
    elif reader == "parquet/pyarrow, columns":
        from pyarrow import parquet

        table = parquet.read_table(path, columns=columns)
        [column.to_numpy() for column in table.columns]
    elif reader == "parquet/pyarrow, batches":
        from pyarrow import parquet

        for batch in parquet.ParquetFile(path).iter_batches(columns=columns):
            for column in batch.columns:
                column.to_numpy(zero_copy_only=False)
    else:
        import pandas

        pandas.read_parquet(path, columns=columns)


def measured(reader: str, path: Path) -> tuple[float, float]:
    """Processor seconds and peak memory in MB, above that of the imports, of one reading in a process of its own."""
    command = [sys.executable, __file__, "--read", reader, str(path)]
    seconds, megabytes = subprocess.run(command, capture_output=True, text=True, check=True).stdout.split()
    return float(seconds), float(megabytes)


def _read_alone(reader: str, path: Path, small: Path) -> None:
    read(reader, small)  # imports, and what is set up once
    before, begin = _peak_kb(), process_time()
    read(reader, path)
    seconds = process_time() - begin
    print(seconds, (_peak_kb() - before) / 1024)


def _peak_kb() -> float:
    """Peak memory of this process, kB; on Linux, where getrusage counts what a parent had as well."""
    status = Path("/proc/self/status").read_text()
    return float(status.split("VmHWM:")[1].split()[0])


def main(arguments: Sequence[str] | None = None) -> int:
    """Make the logs, read them in turns, and print a table; gives the exit code."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--megabytes", type=float, default=20.0, help="size of the MCAP log")
    parser.add_argument("--rows", type=int, default=500_000, help="of the Parquet log")
    parser.add_argument("--repeats", type=int, default=3, help="of each reading; medians are printed")
    parser.add_argument("--read", nargs=2, metavar=("READER", "FILE"), help=argparse.SUPPRESS)
    given = parser.parse_args(arguments)
    if given.read:
        path = Path(given.read[1])
        _read_alone(given.read[0], path, path.with_name(f"small{path.suffix}"))
        return 0
    with tempfile.TemporaryDirectory() as folder:
        logs = {kind: Path(folder) / f"log.{kind}" for kind in ("mcap", "parquet")}
        for name, megabytes, rows in (("small", 0.1, 1000), ("log", given.megabytes, given.rows)):
            write_mcap(Path(folder) / f"{name}.mcap", megabytes)
            write_parquet(Path(folder) / f"{name}.parquet", rows)
        runs: dict[str, list[tuple[float, float]]] = {reader: [] for reader in READERS}
        for _ in range(given.repeats):
            for reader, found in runs.items():
                found.append(measured(reader, logs[reader.partition("/")[0]]))
        print(f"MCAP: {logs['mcap'].stat().st_size / 1e6:.0f} MB; Parquet: {given.rows:,} rows")
    print(
        "| log | reader | processor, s | estexp's time over it | peak memory above imports, MB |\n|---|---|---|---|---|"
    )
    seconds = {reader: median(s for s, _ in found) for reader, found in runs.items()}
    for reader, found in runs.items():
        kind, _, name = reader.partition("/")
        ratio, memory = seconds[f"{kind}/estexp"] / seconds[reader], median(megabytes for _, megabytes in found)
        print(f"| {kind} | {name} | {seconds[reader]:.2f} | {ratio:.2f} | {memory:.0f} |")
    return 0


if __name__ == "__main__":
    sys.exit(main())
