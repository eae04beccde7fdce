"""Write columns of numbers as CSV; reading the file returns the same bits."""

from __future__ import annotations

import csv
import math
import os
import socket
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import numpy as np

from estexp_jax.errors import unwritable


def write_csv(path: str | Path, columns: Mapping[str, np.ndarray]) -> None:
    """Write columns of one length to a CSV file, atomically.

    Floats are written with the fewest digits that give the same float64 back; NaN is an empty cell.

    Args:
        path: the file; its folder must exist.
        columns: header name to values, (rows,) numbers.

    Raises:
        ValueError: the columns differ in length, or are not one-dimensional.
        InputError: the disk is full, or the folder may not be written.
    """
    path = Path(path)
    arrays = {name: np.asarray(values) for name, values in columns.items()}
    arrays = {name: values.astype(int) if values.dtype == bool else values for name, values in arrays.items()}
    shapes = {name: values.shape for name, values in arrays.items()}
    if len(set(shapes.values())) > 1 or any(len(shape) != 1 for shape in shapes.values()):
        raise ValueError(f"columns are not of one length: {shapes}")
    # Written beside its place and then renamed, so that no reader or killed run leaves half a file.
    draft = path.with_name(f".{path.name}.{socket.gethostname()}-{os.getpid()}.part")
    try:
        _write(draft, arrays)
        draft.replace(path)
    except OSError as error:
        raise unwritable(path, error) from None
    finally:
        with suppress(OSError):
            draft.unlink(missing_ok=True)


def _write(draft: Path, arrays: Mapping[str, np.ndarray]) -> None:
    with draft.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(arrays)
        writer.writerows(zip(*([_cell(v) for v in values.tolist()] for values in arrays.values()), strict=True))
        stream.flush()
        os.fsync(stream.fileno())


def _cell(value: float | int) -> str:
    return "" if math.isnan(value) else repr(value)
