"""Read a log into a table, whatever its format."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from estexp_jax.errors import InputError, known
from estexp_jax.recordings.readers.arrow import read_feather
from estexp_jax.recordings.readers.csv import read_csv
from estexp_jax.recordings.readers.hdf5 import hdf5_episodes, read_hdf5
from estexp_jax.recordings.readers.lerobot import read_lerobot
from estexp_jax.recordings.readers.mcap import read_mcap
from estexp_jax.recordings.readers.npz import read_npz
from estexp_jax.recordings.readers.parquet import read_parquet
from estexp_jax.recordings.readers.rosbag import is_bag_folder, read_bag_folder, read_rosbag
from estexp_jax.recordings.table import Selection, Table


def read_table(path: str | Path, selection: Selection = Selection()) -> Table:  # noqa: B008 frozen, so shared safely
    """Read a log; the format follows the file name's extension.

    Args:
        path: a file of a known kind (`_READERS`), the folder of a LeRobot data set, or that of a ROS 2 bag.
        selection: which part of the file.

    Raises:
        InputError: the file does not exist, its extension is unknown, its contents do not match the extension, it is
            too large, or the selection does not apply to this format.
    """
    path = Path(path)
    try:
        return _reader(path, selection)(path, selection)
    except MemoryError:
        raise InputError("does not fit into memory", where=str(path), right="cut it into shorter logs") from None
    except (OSError, ValueError) as error:  # a ValueError: a path with a null byte in it
        raise InputError(f"cannot be read: {error}", where=str(path)) from None


def holds_episodes(path: str | Path) -> bool:
    """Whether a log is a data set of episodes, of which a recording is one."""
    path = Path(path)
    if path.is_dir():
        return (path / "meta" / "info.json").is_file()
    return _READERS.get(_kind(path)) is read_hdf5 and hdf5_episodes(path)


def is_log_folder(path: Path) -> bool:
    """Whether a folder is a log: a LeRobot data set or a ROS 2 bag."""
    return path.is_dir() and (holds_episodes(path) or is_bag_folder(path))


def _kind(path: Path) -> str:
    """The ending that says the format; of a compressed file with that of what is compressed."""
    endings = [suffix.lower() for suffix in path.suffixes[-2:]]
    return "".join(endings) if endings[-1:] in ([".zstd"], [".zst"]) else "".join(endings[-1:])


def _reader(path: Path, selection: Selection) -> Callable[[Path, Selection], Table]:
    if path.is_dir():
        reader = read_bag_folder if not holds_episodes(path) and is_bag_folder(path) else read_lerobot
    elif not path.is_file():
        raise InputError("no such recording", where=str(path), right="give the path of a log")
    else:
        kind = _kind(path)
        if kind not in _READERS:
            right = f"{known(_READERS)}, and folders of LeRobot data sets and of ROS 2 bags"
            raise InputError(f"unknown kind of recording '{kind}'", where=str(path), right=right)
        reader = _READERS[kind]
    if selection.episode is not None and reader not in _OF_EPISODES:
        raise InputError("has no episodes", where=str(path), right="`episode` is for LeRobot data sets and HDF5")
    if (selection.clock != "log" or selection.clocks) and reader not in _OF_TOPICS:
        raise InputError("has one clock", where=str(path), right="`clock` is for logs of topics, such as MCAP files")
    return reader


_READERS: Mapping[str, Callable[[Path, Selection], Table]] = {
    ".csv": read_csv,
    ".npz": read_npz,
    ".parquet": read_parquet,
    ".mcap": read_mcap,
    ".mcap.zstd": read_mcap,
    ".mcap.zst": read_mcap,
    ".tsv": read_csv,
    **dict.fromkeys((".feather", ".arrow", ".ipc"), read_feather),
    **dict.fromkeys((".h5", ".hdf5", ".hdf", ".mat"), read_hdf5),
    **dict.fromkeys((".db3", ".bag"), read_rosbag),
}
_OF_TOPICS = (read_mcap, read_rosbag, read_bag_folder)
_OF_EPISODES = (read_lerobot, read_parquet, read_hdf5)
