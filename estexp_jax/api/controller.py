"""Controllers that `estexp recover --hardware` has written, to be run by a program of the user's."""

from __future__ import annotations

import zipfile
import zlib
from pathlib import Path

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.recovery.hardware.onboard import ARRAYS, OnboardController

_BROKEN = (OSError, EOFError, ValueError, KeyError, TypeError, RuntimeError, MemoryError)
_BROKEN += (zipfile.BadZipFile, zlib.error)


def load_controller(path: str | Path) -> OnboardController:
    """A controller, ready to drive a robot.

    ```python
    controller = ee.load_controller("robot/controller_0.npz")
    hidden = controller.hidden()
    for _ in range(controller.steps):  # one every controller.control_step seconds
        hidden, commands = controller.respond(hidden, read_sensors(controller.inputs))
        send(dict(zip(controller.actuators, commands)))
    ```

    Args:
        path: a `controller_<i>.npz`.

    Raises:
        InputError: it cannot be read, or is something else.
    """
    path = Path(path)
    if not path.is_file():
        raise InputError("no such controller", where=str(path), right="a controller_<i>.npz of estexp recover")
    try:
        with np.load(path, allow_pickle=False) as archive:
            return OnboardController.from_arrays({name: archive[name] for name in ARRAYS})
    except _BROKEN as error:
        right = "a controller_<i>.npz of estexp recover"
        raise InputError(f"is no controller: {error}", where=str(path), right=right) from None
