"""The robot in the world: it takes a controller and returns a recorded trial.

Trials are the scarce resource; `RunState.trials` keeps and counts them. A target is any callable that takes a
`Controller` and returns a `Trial`, or a dict of its arrays. The two targets of the package are simulated.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol, final, runtime_checkable

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.changes import Change
from estexp_jax.recovery.control.trial import Controller, Trial
from estexp_jax.recovery.simulator import DamageSimulator


class Target(Protocol):
    """A robot in the world."""

    def __call__(self, controller: Controller) -> Trial | Mapping[str, Any]:
        """Drive the robot, from rest, for `controller.steps` control steps of `controller.control_step`.

        Returns:
            The trial, or a dict as `trial_of_result` takes it.
        """
        ...


def trial_of_result(result: Any, controller: Controller) -> Trial:
    """The trial that a target gave, checked.

    Args:
        result: a `Trial`, or a dict: `readings` (steps, inputs), or `sensor.<name>` (steps,) of each input; of these
            may be missing `commands` (steps, motors), which then are the controller's for these readings, `position`
            (steps, 3) of the root, m, and `time` (steps,), s.
        controller: that drove the robot.

    Raises:
        InputError: it is something else, or lacks readings, or has other shapes or values that are not finite.
    """
    inputs, steps = controller.interface.names, controller.steps
    right = f"return a Trial, or a dict with readings ({steps}, {len(inputs)}) of {', '.join(inputs)}, touch as +1/-1"
    if isinstance(result, Trial):
        given: Mapping[str, Any] = {
            name: getattr(result, name) for name in ("time", "readings", "commands", "position")
        }
    elif isinstance(result, Mapping):
        given = result
    else:
        raise InputError(f"it gave {type(result).__name__}", where="target", right=right)
    try:
        tables = {str(name): np.asarray(table, float) for name, table in given.items()}
    except (TypeError, ValueError):
        raise InputError("it gave something that is no array of numbers", where="target", right=right) from None
    if "readings" not in tables and (missing := [n for n in inputs if f"sensor.{n}" not in tables]):
        raise InputError(f"no readings of {', '.join(missing)}", where="target", right=right)
    readings = tables.get("readings")
    if readings is None:
        lengths = {len(tables[f"sensor.{n}"]) for n in inputs}
        if len(lengths) > 1:
            raise InputError("readings of different lengths", where="target", right=right)
        readings = np.stack([tables[f"sensor.{n}"] for n in inputs], axis=1)
    if readings.shape != (steps, len(inputs)):
        raise InputError(f"readings are {readings.shape}", where="target", right=right)
    if not np.isfinite(readings).all():
        raise InputError(
            "readings are not all finite", where="target", right="of a lost sensor give what it reads then"
        )
    time = tables.get("time", controller.control_step * np.arange(steps))
    commands = tables["commands"] if "commands" in tables else _commands(controller, readings)
    position = tables.get("position", np.full((steps, 3), np.nan))
    shapes = {"time": (time, (steps,)), "commands": (commands, (steps, controller.interface.n_outputs))}
    for name, (table, shape) in (shapes | {"position": (position, (steps, 3))}).items():
        if table.shape != shape:
            raise InputError(f"{name} is {table.shape}", where="target", right=f"{name} {shape}")
    played = result.open_loop_readings if isinstance(result, Trial) else None
    return Trial(time, readings, commands, position, played)


def _commands(controller: Controller, readings: np.ndarray) -> np.ndarray:
    """Commands (steps, motors) that the controller gives for readings."""
    hidden, found = controller.rest(), []
    for row in readings:
        hidden, command = controller.respond(hidden, row)
        found.append(command)
    return np.array(found)


@runtime_checkable
class RemoteTarget(Protocol):
    """A robot in the world that somebody else operates, so that each trial is requested first."""

    def perform(self, number: int, controller: Controller, predicted: Trial) -> Trial:
        """Run a trial as `Target` does.

        Args:
            number: of the trial, from 0; the same if it is requested again after an interruption.
            controller: that drives the robot.
            predicted: the trial that the simulator, as diagnosed so far, predicts.
        """
        ...


@runtime_checkable
class FilmedTarget(Protocol):
    """A robot whose motion is known, so that it can be drawn."""

    def motion(self, controller: Controller, rows: Sequence[int]) -> np.ndarray:
        """Configurations (len(rows), nq) of the nominal robot's coordinates at control steps of the same trial."""
        ...


@final
class SameTarget:
    """The simulator itself with damage planted in it: only the damage is unknown.

    Args:
        simulator: its catalogue holds the planted effects.
        planted: the damage; kept as an attribute.
    """

    def __init__(self, simulator: DamageSimulator, planted: Sequence[Change]) -> None:
        self._simulator, self.planted = simulator, tuple(planted)

    def __call__(self, controller: Controller) -> Trial:
        """See `Target`."""
        return self._simulator.trial(self.planted, controller.weights, controller.steps)

    def motion(self, controller: Controller, rows: Sequence[int]) -> np.ndarray:
        """See `FilmedTarget`."""
        return self._simulator.motions([self.planted], controller.weights[None], rows)[0]
