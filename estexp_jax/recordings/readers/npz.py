"""Read NumPy archives with one array a column; sizes are checked before memory is allocated."""

from __future__ import annotations

import math
import tokenize
import warnings
import zipfile
import zlib
from lzma import LZMAError
from pathlib import Path
from typing import IO, Any

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.recordings.readers.stamps import is_stamp, seconds
from estexp_jax.recordings.table import Selection, Table, check_size, check_width

# Exceptions from damaged members: wrong lengths, checksums, encryption, unknown compression, damaged headers.
_BROKEN = (ValueError, EOFError, OSError, zipfile.BadZipFile, zlib.error, LZMAError)
_BROKEN += (RuntimeError, OverflowError, TypeError, KeyError, MemoryError, SyntaxError, IndexError)
_BROKEN += (tokenize.TokenError,)  # of NumPy's parser of headers


def read_npz(path: Path, selection: Selection) -> Table:
    """Read a NumPy archive with one array a column, (rows,) or (rows, k). Pickled objects are refused.

    Raises:
        InputError: the file is not a NumPy archive, or too large.
    """
    columns: dict[str, np.ndarray] = {}
    unusable: dict[str, InputError] = {}
    try:
        with zipfile.ZipFile(path) as archive:
            members = [info for info in archive.infolist() if info.filename.endswith(".npy")]
            check_width(len(members), str(path))
            for name, info in {info.filename.removesuffix(".npy"): info for info in members}.items():
                taken = sum(values.size for values in columns.values())
                try:
                    with warnings.catch_warnings():
                        warnings.simplefilter("ignore")  # NumPy's, of headers in the manner of Python 2
                        whole = _read_column(archive, info, taken, f"{path}, column '{name}'")
                    alone = len(members) == 1
                    columns |= array_columns(name, whole, alone)
                except _BROKEN as error:
                    unusable[name] = InputError(f"is no column: {error}", where=f"{path}, column '{name}'")
    except _BROKEN:
        raise InputError("is not a NumPy .npz archive", where=str(path), right="write it with numpy.savez") from None
    return plain_table(columns, unusable, str(path))


def array_columns(name: str, values: np.ndarray, alone: bool) -> dict[str, np.ndarray]:
    """The columns of an array: itself, or of a structured one `array.field`, or `field` if it is alone."""
    if values.dtype.names is None:
        return {name: values}
    found: dict[str, np.ndarray] = {}
    for field in values.dtype.names:
        found |= array_columns(field if alone else f"{name}.{field}", values[field], False)
    return found


def numbers_of(columns: dict[str, np.ndarray], source: str) -> tuple[dict[str, np.ndarray], dict[str, InputError]]:
    """The columns of numbers and times, and errors for the others, such as texts in a structured array."""
    unusable: dict[str, InputError] = {}
    for name, values in columns.items():
        if values.dtype.kind not in "fiubmM" or values.ndim not in (1, 2):
            what = f"is no column: it holds {values.dtype} of the shape {values.shape}, not numbers"
            unusable[name] = InputError(what, where=f"{source}, column '{name}'")
    return {name: values for name, values in columns.items() if name not in unusable}, unusable


def plain_table(columns: dict[str, np.ndarray], unusable: dict[str, InputError], source: str, **more: Any) -> Table:
    """A log of arrays of any kind: time stamps as seconds, what holds no numbers as errors; `more` is for it."""
    usable, others = numbers_of(columns, source)
    stamps = frozenset(name for name, values in usable.items() if is_stamp(values))
    with np.errstate(over="ignore"):
        plain = {name: seconds(v) if name in stamps else v.astype(np.float64) for name, v in usable.items()}
    return Table(source, plain, unusable | others, stamps=stamps, **more)


def _read_column(archive: zipfile.ZipFile, info: zipfile.ZipInfo, taken: int, where: str) -> np.ndarray:
    """One member's numbers. Its header is checked first, as an archive of kilobytes can claim terabytes."""
    with archive.open(info) as stream:
        shape, dtype = _read_header(stream)
    if dtype.hasobject or (dtype.names is None and dtype.kind not in "fiubmM"):
        raise ValueError(f"it holds {dtype}, not numbers")
    if len(shape) not in ((1, 2) if dtype.names is None else (1,)) or min(shape) < 0:
        raise ValueError(f"its shape is {shape}, not (rows,) or (rows, values)")
    check_size(taken + math.prod(shape) * max(1, dtype.itemsize // 8 if dtype.names else 1), where)
    if math.prod(shape) * dtype.itemsize > info.file_size:
        raise ValueError(f"its shape is {shape}, but it holds {info.file_size} bytes")
    with archive.open(info) as stream, np.errstate(over="ignore"):
        return np.lib.format.read_array(stream, allow_pickle=False)


def _read_header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype]:
    version = np.lib.format.read_magic(stream)
    readers = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    if version not in readers:
        raise ValueError(f"its header is of version {version}, which holds no plain numbers")
    shape, _, dtype = readers[version](stream)
    return shape, dtype
