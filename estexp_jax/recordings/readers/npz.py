"""Read NumPy archives with one array a column; sizes are checked before memory is allocated."""

from __future__ import annotations

import math
import tokenize
import warnings
import zipfile
import zlib
from lzma import LZMAError
from pathlib import Path
from typing import IO

import numpy as np

from estexp_jax.errors import InputError
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
                        columns[name] = _read_column(archive, info, taken, f"{path}, column '{name}'")
                except _BROKEN as error:
                    unusable[name] = InputError(f"is no column: {error}", where=f"{path}, column '{name}'")
    except _BROKEN:
        raise InputError("is not a NumPy .npz archive", where=str(path), right="write it with numpy.savez") from None
    return Table(str(path), columns, unusable)


def _read_column(archive: zipfile.ZipFile, info: zipfile.ZipInfo, taken: int, where: str) -> np.ndarray:
    """One member's numbers. Its header is checked first, as an archive of kilobytes can claim terabytes."""
    with archive.open(info) as stream:
        shape, dtype = _read_header(stream)
    if dtype.kind not in "fiub":
        raise ValueError(f"it holds {dtype}, not numbers")
    if len(shape) not in (1, 2) or min(shape) < 0:
        raise ValueError(f"its shape is {shape}, not (rows,) or (rows, values)")
    check_size(taken + math.prod(shape), where)
    if math.prod(shape) * dtype.itemsize > info.file_size:
        raise ValueError(f"its shape is {shape}, but it holds {info.file_size} bytes")
    with archive.open(info) as stream, np.errstate(over="ignore"):
        return np.lib.format.read_array(stream, allow_pickle=False).astype(np.float64)


def _read_header(stream: IO[bytes]) -> tuple[tuple[int, ...], np.dtype]:
    version = np.lib.format.read_magic(stream)
    readers = {(1, 0): np.lib.format.read_array_header_1_0, (2, 0): np.lib.format.read_array_header_2_0}
    if version not in readers:
        raise ValueError(f"its header is of version {version}, which holds no plain numbers")
    shape, _, dtype = readers[version](stream)
    return shape, dtype
