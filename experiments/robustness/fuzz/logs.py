"""Bad logs: a good one with damage, or made of the format's own parts in ways that nobody meant."""

from __future__ import annotations

import io
import json
import random
import stat
import warnings
import zipfile
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from experiments.robustness.fuzz import draw

ROWS = 40
MODEL = """<mujoco><worldbody><body><joint name="elbow" axis="0 1 0"/><geom size=".1"/></body></worldbody>
<actuator><position name="servo" joint="elbow" ctrlrange="-1 1"/></actuator>
<sensor><jointpos name="angle" joint="elbow"/></sensor></mujoco>
"""
NAMES = ("time", "goal", "position", "ctrl.servo", "sensor.angle", "qpos.elbow", "enable.servo", "ctrl.x", "", "x")
MAP = ("--map", "ctrl.servo=goal", "--map", "sensor.angle=position")
MCAP_MAP = ("--map", "ctrl.servo=/goal.position[0]", "--map", "sensor.angle=/joint_states.position[0]")
DTYPES = ("f8", "f4", "f2", "i8", "u8", "i1", "?", "c16", "U3", "S2", "M8[s]", "O", "f8,i4", "V4", "g")
SHAPES = ((), (0,), (3,), (4,), (3, 2), (3, 0), (2, 3, 4), (1,))


def columns() -> dict[str, np.ndarray]:
    """A good log."""
    time = np.arange(ROWS) * 0.01
    return {"time": time, "goal": np.sin(time), "position": np.cos(time)}


def model(folder: Path) -> Path:
    """The robot that all logs are of."""
    path = folder / "arm.xml"
    path.write_text(MODEL)
    return path


def csv(source: random.Random, folder: Path) -> list[str]:
    """A comma-separated file."""
    header, *rows = good_csv().decode().splitlines()
    match source.randrange(5):
        case 0:
            content = draw.mutated(source, good_csv())
        case 1:
            content = _cells(source).encode("utf-8", "surrogatepass")
        case 2:
            names = [source.choice((*NAMES, *draw.TEXTS)) for _ in range(source.randint(1, 5))]
            content = "\n".join([",".join(names), *rows]).encode()
        case 3:
            row = source.randrange(len(rows))
            cells = rows[row].split(",")
            cells[source.randrange(3)] = source.choice((*draw.NUMBERS, *draw.TEXTS))
            rows[row] = source.choice((",", ";", "\t", ",,")).join(cells)
            content = "\n".join([header, *rows]).encode(source.choice(("utf-8", "utf-16", "latin-1")), "replace")
        case _:
            source.shuffle(rows)
            content = "\n".join([header, *rows[: source.randrange(len(rows))]]).encode()
    return _checked(folder, "log.csv", content)


def _cells(source: random.Random) -> str:
    rows = []
    for _ in range(source.randint(0, 6)):
        rows.append(",".join(source.choice((*draw.NUMBERS, *draw.TEXTS, '"')) for _ in range(source.randint(1, 4))))
    return "\n".join([",".join(source.choice(NAMES) for _ in range(source.randint(1, 4))), *rows])


@lru_cache(maxsize=1)
def good_csv() -> bytes:
    """The good log as it would be written."""
    table = columns()
    rows = [",".join(f"{float(v)!r}" for v in row) for row in zip(*table.values(), strict=True)]
    return "\n".join([",".join(table), *rows]).encode()


def npz(source: random.Random, folder: Path) -> list[str]:
    """A NumPy archive."""
    match source.randrange(4):
        case 0:
            content = draw.mutated(source, good_npz())
        case 1:
            content = _npz({source.choice(NAMES) or "x": _array(source) for _ in range(source.randint(0, 4))})
        case 2:
            content = _npz(columns() | {source.choice(("time", "goal", "position")): _array(source)})
        case _:
            content = _archive(source)
    return _checked(folder, "log.npz", content)


def _array(source: random.Random) -> np.ndarray:
    made = np.zeros(source.choice(SHAPES), dtype=source.choice(DTYPES))
    if made.dtype.kind in "fc" and made.size:
        with np.errstate(all="ignore"):
            made.flat[:] = np.array([draw.number(source) for _ in range(made.size)]).astype(made.dtype)
    return made


def _npz(arrays: dict[str, np.ndarray]) -> bytes:
    stream = io.BytesIO()
    np.savez_compressed(stream, allow_pickle=True, **arrays)  # objects are among what is tried
    return stream.getvalue()


@lru_cache(maxsize=1)
def good_npz() -> bytes:
    """The good log as an archive."""
    return _npz(columns())


def _archive(source: random.Random) -> bytes:
    """A zip with headers that lie, bombs, links, names that lead out, members twice."""
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", source.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED, zipfile.ZIP_LZMA))) as z:
        for name in ("time", "goal", "position"):
            for _ in range(source.choice((1, 1, 2))):
                place = source.choice((name, name, f"../{name}", f"/tmp/{name}", f"a/../{name}"))
                info = zipfile.ZipInfo(f"{place}.npy")
                if draw.chance(source, 0.2):
                    info.external_attr = (stat.S_IFLNK | 0o777) << 16
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")  # of names that are there twice, which is what is wanted
                    z.writestr(info, _member(source))
    return stream.getvalue()


def _member(source: random.Random) -> bytes:
    huge = source.choice(((10**15,), (10**6, 10**9), (-5,), (3, -3), (2**62, 4), (ROWS,)))
    shape = huge if draw.chance(source, 0.7) else (source.randint(0, 60),)
    stream, kind = io.BytesIO(), source.choice(("<f8", "|O", "<U9", "<i4", ">f4"))
    np.lib.format.write_array_header_1_0(stream, {"descr": kind, "fortran_order": False, "shape": shape})
    filler = bytes(source.choice((0, 7, 8 * ROWS, 2**20)))
    return (draw.mutated(source, stream.getvalue()) if draw.chance(source, 0.2) else stream.getvalue()) + filler


def parquet(source: random.Random, folder: Path) -> list[str]:
    """A Parquet file."""
    match source.randrange(3):
        case 0:
            content = draw.mutated(source, good_parquet())
        case 1:
            content = _parquet([(source.choice(NAMES), _column(source)) for _ in range(source.randint(1, 5))])
        case _:
            table: dict[str, Any] = {name: list(values[:3]) for name, values in columns().items()}
            table[source.choice(list(table))] = _column(source)
            content = _parquet(list(table.items()))
    return _checked(folder, "log.parquet", content)


def _column(source: random.Random) -> list[Any]:
    kinds = (
        lambda: draw.number(source),
        lambda: [draw.number(source) for _ in range(source.randint(0, 3))],
        lambda: source.choice(draw.TEXTS),
        lambda: source.randint(-(2**63), 2**63 - 1),
        lambda: {"a": draw.number(source)},
        lambda: None,
    )
    made = source.choice(kinds)
    return [made() for _ in range(3)]


def _parquet(table: list[tuple[str, Any]]) -> bytes:
    import pyarrow
    from pyarrow import parquet as files

    sink = pyarrow.BufferOutputStream()
    arrays = [pyarrow.array(values) for _, values in table]
    files.write_table(pyarrow.Table.from_arrays(arrays, names=[name for name, _ in table]), sink)
    return sink.getvalue().to_pybytes()


@lru_cache(maxsize=1)
def good_parquet() -> bytes:
    """The good log as Parquet."""
    return _parquet(list(columns().items()))


def mcap(source: random.Random, folder: Path) -> list[str]:
    """An MCAP file."""
    content = draw.mutated(source, good_mcap()) if draw.chance(source, 0.5) else _mcap(_messages(source))
    if draw.chance(source, 0.2):
        content = draw.mutated(source, content)
    return _checked(folder, "log.mcap", content, MCAP_MAP)


def _messages(source: random.Random) -> list[tuple[str, int, bytes]]:
    found = []
    for _ in range(source.randint(0, 8)):
        data = json.dumps(draw.value(source)).encode() if draw.chance(source, 0.5) else source.randbytes(6)
        if draw.chance(source, 0.4):
            data = json.dumps({"position": [draw.number(source) for _ in range(source.randint(0, 2))]}).encode()
        time = source.choice((0, 10**9, 2**63, 2**64 - 1, source.getrandbits(40)))
        found.append((source.choice(("/goal", "/joint_states")), time, data))
    return found


def _mcap(messages: list[tuple[str, int, bytes]]) -> bytes:
    from mcap.writer import Writer

    stream = io.BytesIO()
    writer = Writer(stream)
    writer.start()
    channels = {topic: writer.register_channel(topic, "json", 0) for topic in ("/goal", "/joint_states")}
    for topic, time, data in messages:
        writer.add_message(channels[topic], log_time=time, publish_time=time, data=data)
    writer.finish()
    return stream.getvalue()


@lru_cache(maxsize=1)
def good_mcap() -> bytes:
    """The good log as MCAP."""
    messages = []
    for time, goal, position in zip(*columns().values(), strict=True):
        for topic, number in (("/goal", goal), ("/joint_states", position)):
            messages.append((topic, 10**18 + round(1e9 * time), json.dumps({"position": [float(number)]}).encode()))
    return _mcap(messages)


def _checked(folder: Path, name: str, content: bytes, mapping: tuple[str, ...] = MAP) -> list[str]:
    """Write a log, sometimes as what is no plain file, and give the command that judges it."""
    (folder / name).write_bytes(content)
    return ["check", str(model(folder)), str(folder / name), *mapping]
