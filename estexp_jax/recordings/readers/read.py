"""Read a log in any supported format: CSV, NPZ, Parquet, LeRobot data set, MCAP."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path

from estexp_jax.errors import InputError, known
from estexp_jax.recordings.readers.csv import read_csv
from estexp_jax.recordings.readers.lerobot import read_lerobot
from estexp_jax.recordings.readers.mcap import read_mcap
from estexp_jax.recordings.readers.npz import read_npz
from estexp_jax.recordings.readers.parquet import read_parquet
from estexp_jax.recordings.table import Selection, Table

CLOCKS = ("log", "publish", "header")
"""Clocks of the messages in an MCAP file."""


def read_table(path: str | Path, selection: Selection = Selection()) -> Table:  # noqa: B008 frozen, so shared safely
    """Read a log; the format follows the file name's extension, and a folder is a LeRobot data set.

    Args:
        path: .csv, .npz, .parquet or .mcap, or a folder with `meta/info.json`.
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


def _reader(path: Path, selection: Selection) -> Callable[[Path, Selection], Table]:
    if path.is_dir():
        kind, reader = "folder", read_lerobot
    elif not path.is_file():
        raise InputError("no such recording", where=str(path), right="give the path of a log")
    else:
        kind = path.suffix.lower()
        if kind not in _READERS:
            right = f"{known(_READERS)}, and folders of LeRobot data sets"
            raise InputError(f"unknown kind of recording '{kind}'", where=str(path), right=right)
        reader = _READERS[kind]
    if selection.episode is not None and kind not in ("folder", ".parquet"):
        raise InputError("has no episodes", where=str(path), right="`episode` is for LeRobot data sets")
    if selection.clock != "log" and kind != ".mcap":
        raise InputError("has one clock", where=str(path), right="`clock` is for MCAP files")
    return reader


_READERS: Mapping[str, Callable[[Path, Selection], Table]] = {
    ".csv": read_csv,
    ".npz": read_npz,
    ".parquet": read_parquet,
    ".mcap": read_mcap,
}
