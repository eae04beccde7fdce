"""`load_controller`: a controller that `estexp recover --hardware` has written, for a program of the user's."""

from __future__ import annotations

from pathlib import Path

from estexp_jax.api.options.keywords import front_door
from estexp_jax.hardware.controller_files import read_controller
from estexp_jax.hardware.onboard import OnboardController


@front_door()
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
    return read_controller(Path(path))
