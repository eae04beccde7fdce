"""Read bags of ROS: the folders of rosbag2 (MCAP or SQLite), single .db3 files, and ROS 1's .bag, by `rosbags`."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.decoding import MOST_DEFINITION_BYTES, check_definition, plain_cdr, unpacked
from estexp_jax.recordings.readers.mcap import read_mcaps
from estexp_jax.recordings.readers.topics import TopicMerger
from estexp_jax.recordings.table import Selection, Table

_METADATA = "metadata.yaml"
_MCAP, _DATABASE = (".mcap", ".mcap.zstd"), ".db3"
_MOST_BYTES = 2**20
"""Size limit of a bag's description, whose parser takes its time."""


def is_bag_folder(path: Path) -> bool:
    """Whether a folder is a bag of rosbag2, also of one whose recorder died before it wrote the metadata.

    Its files are then known by the folder's name: other logs in one folder are several recordings.
    """
    if (path / _METADATA).is_file():
        return True
    names = [file.name for file in _files(path, (*_MCAP, _DATABASE))]
    return bool(names) and all(re.fullmatch(rf"{re.escape(path.resolve().name)}_\d+\.\S+", name) for name in names)


def read_bag_folder(path: Path, selection: Selection) -> Table:
    """Read the folder of a bag, all its files as one log.

    Raises:
        InputError: there is no bag in it, or it cannot be read.
    """
    mcaps = _files(path, _MCAP)
    if mcaps:
        return read_mcaps(_in_order(path, mcaps), str(path), selection)
    databases = _files(path, (_DATABASE,))
    if len(databases) == 1 and not (path / _METADATA).is_file():
        return read_rosbag(databases[0], selection)
    return read_rosbag(path, selection)


def read_rosbag(path: Path, selection: Selection) -> Table:
    """Read a .bag, a .db3, or the folder of a bag in SQLite.

    Bags of older recorders hold no definitions; those of the newest distribution stand in for them.

    Raises:
        InputError: it is no bag, damaged, or the extra `ros` is not installed.
    """
    try:
        from rosbags.highlevel import AnyReader
        from rosbags.typesys import Stores, get_typestore
    except ImportError:
        right = "pip install 'estexp_jax[ros]'"
        raise InputError("is a ROS bag, which needs the extra `ros`", where=str(path), right=right) from None
    merger = TopicMerger(str(path), selection)
    _refuse_long(path / _METADATA)
    try:
        reader = AnyReader([path], default_typestore=get_typestore(Stores.LATEST))
        _check_definitions(reader)
        with reader:
            for connection in reader.connections:
                merger.open(_key(connection), connection.topic, partial(_decoder, reader, connection))
            wanted = [c for c in reader.connections if merger.open(_key(c), c.topic, _unknown)]
            for connection, time, data in reader.messages(connections=wanted) if wanted else ():
                if merger.open(_key(connection), connection.topic, _unknown):
                    merger.add(_key(connection), bytes(data), time, time)
    except InputError:
        raise
    except Exception as error:  # a parser may raise anything on damaged bytes
        reason = " ".join(f"{error or type(error).__name__}".split())[:200]
        raise InputError(f"is not a ROS bag, or is damaged: {reason}", where=str(path)) from None
    return merger.table([])


def _refuse_long(metadata: Path) -> None:
    if metadata.is_file() and metadata.stat().st_size > _MOST_BYTES:
        raise InputError(
            f"is {metadata.stat().st_size:,} bytes long", where=str(metadata), right=f"at most {_MOST_BYTES:,}"
        )


def _check_definitions(reader: Any) -> None:
    """See that the definitions of all topics can be parsed in no time, since the reader parses them when it is opened.

    Raises:
        ValueError: one cannot, or all together cannot.
    """
    lengths: dict[str, int] = {}
    for bag in reader.readers:
        bag.open()
        try:
            for connection in bag.connections:
                check_definition(connection.msgdef.data)
                lengths[connection.msgtype] = len(connection.msgdef.data)
        finally:
            bag.close()
    if sum(lengths.values()) > MOST_DEFINITION_BYTES:
        raise ValueError(f"the definitions of its messages have more than {MOST_DEFINITION_BYTES:,} characters")


def _key(connection: Any) -> tuple[int, int]:
    return id(connection.owner), connection.id


def _unknown() -> Callable[[Any], Any]:
    raise ValueError("the bag did not say that it holds this topic")


def _decoder(reader: Any, connection: Any) -> Callable[[bytes], Any]:
    def decode(data: bytes) -> Any:
        return reader.deserialize(plain_cdr(unpacked(data)) if reader.is2 else data, connection.msgtype)

    return decode


def _files(folder: Path, suffixes: tuple[str, ...]) -> list[Path]:
    """Files of a folder with these endings, in the order of the numbers in their names."""
    found = [path for path in folder.iterdir() if path.name.lower().endswith(suffixes) and path.is_file()]
    return sorted(found, key=lambda path: [int(k) if k.isdecimal() else k for k in re.split(r"(\d+)", path.name)])


def _in_order(folder: Path, files: list[Path]) -> list[Path]:
    """The files that the bag's description names, in its order; all where it names none."""
    metadata = folder / _METADATA
    if not metadata.is_file() or metadata.stat().st_size > _MOST_BYTES:
        return files
    text = metadata.read_text(encoding="utf-8", errors="replace")
    named = [
        Path(name.strip("'\"")).name for name in re.findall(r"^\s*-\s+(\S+\.mcap(?:\.zstd)?['\"]?)\s*$", text, re.M)
    ]
    listed = [folder / name for name in dict.fromkeys(named) if folder / name in files]
    return listed or files
