"""Controllers in files, read back."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.hardware.onboard import ARRAYS, OnboardController

_BROKEN = (OSError, EOFError, ValueError, KeyError, TypeError, RuntimeError, MemoryError)
_BROKEN += (zipfile.BadZipFile, zlib.error)


def read_controller(path: Path) -> OnboardController:
    """The controller in a `controller_<i>.npz`.

    Raises:
        InputError: it cannot be read, or is something else.
    """
    right = "a controller_<i>.npz of estexp recover"
    if not path.is_file():
        raise InputError("no such controller", where=str(path), right=right)
    try:
        with np.load(path, allow_pickle=False) as archive:
            return OnboardController.from_arrays({name: archive[name] for name in ARRAYS})
    except _BROKEN as error:
        raise InputError(f"is no controller: {error}", where=str(path), right=right) from None
