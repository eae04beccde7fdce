"""The record of a robot's trial, and the controller that drove it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple, final

import jax
import jax.numpy as jnp
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.engines.controller_interface import Interface
from estexp_jax.recovery.control.network import HIDDEN, Network, decode, n_weights

AXES = {"x": (0, 1.0), "-x": (0, -1.0), "y": (1, 1.0), "-y": (1, -1.0)}
"""Axis of travel: component of the root's position, and sign."""
_TABLES = ("time", "readings", "commands", "position")


@final
@dataclass(frozen=True, eq=False)
class Trial:
    """One recorded trial; rows are control steps.

    Attributes:
        time: (rows,) s.
        readings: (rows, n_inputs) raw readings before the row's command acts; touch as +1/-1.
        commands: (rows, nu) in each actuator's unit.
        position: (rows, 3) of the root, m; NaN where not measured.
        open_loop_readings: (rows, n_inputs) readings for which the network gives the commands, if these were played
            open loop; None if the loop was closed.

    Raises:
        InputError: the tables differ in length.
    """

    time: np.ndarray
    readings: np.ndarray
    commands: np.ndarray
    position: np.ndarray
    open_loop_readings: np.ndarray | None = None

    def __post_init__(self) -> None:
        rows = len(self.time)
        if any(len(table) != rows for table in (self.readings, self.commands, self.position, self.network_readings)):
            raise InputError("a trial's time, readings, commands and position differ in length", where="trial")

    @property
    def network_readings(self) -> np.ndarray:
        """Readings (rows, n_inputs) for which the network gives the commands."""
        return self.readings if self.open_loop_readings is None else self.open_loop_readings

    def distance(self, axis: str) -> float:
        """Distance that the root travelled along an axis, m; NaN if unknown."""
        return float(distances_along(self.position, axis))

    def to_tree(self) -> dict[str, np.ndarray]:
        """The tree of plain data that a checkpoint holds."""
        return {name: getattr(self, name) for name in (*_TABLES, "open_loop_readings")}

    @classmethod
    def from_tree(cls, tree: dict[str, Any]) -> Trial:
        """The inverse of `to_tree`."""
        given = tree.get("open_loop_readings")
        tables = (np.asarray(tree[name]) for name in _TABLES)
        return cls(*tables, open_loop_readings=None if given is None else np.asarray(given))


def distances_along(position: np.ndarray, axis: str) -> np.ndarray:
    """Distances (...) that roots at positions (..., rows, 3) travelled along an axis, m."""
    component, sign = AXES[axis]
    return sign * (position[..., -1, component] - position[..., 0, component])


@final
@dataclass(frozen=True, eq=False)
class Controller:
    """A network as a robot in the world runs it.

    Attributes:
        weights: (n_weights,) in [-1, 1].
        interface: its sensors and motors.
        gain: of the neurons' tanh.
        control_step: time between two commands, s.
        steps: commands of a trial.
    """

    weights: np.ndarray
    interface: Interface
    gain: float
    control_step: float
    steps: int

    def network(self) -> Network:
        """The network of its weights."""
        face = self.interface
        if len(self.weights) != n_weights(face.n_inputs, face.n_outputs):
            raise InputError(f"{len(self.weights)} weights", where="controller", right="the robot's own controller")
        return decode(jnp.asarray(self.weights, jnp.float32), face.n_inputs, face.n_outputs)

    def rest(self) -> np.ndarray:
        """Hidden outputs (HIDDEN,) before the first step."""
        return np.zeros(HIDDEN, np.float32)

    def respond(self, hidden: np.ndarray, readings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """One control step.

        Args:
            hidden: (HIDDEN,) of the step before; `rest()` at first.
            readings: (n_inputs,) raw, touch as +1/-1, in the order of `interface.names`.

        Returns:
            Hidden outputs (HIDDEN,) for the next step, and commands (nu,) in each actuator's unit.
        """
        return controller_step(self.network(), self.interface, self.gain, hidden, readings)


class Scales(NamedTuple):
    """The arrays of an `Interface` that a controller computes with; see there."""

    centre: np.ndarray
    scale: np.ndarray
    ctrl_centre: np.ndarray
    ctrl_scale: np.ndarray
    ctrl_low: np.ndarray
    ctrl_high: np.ndarray


def controller_step(
    network: Network, interface: Interface | Scales, gain: float, hidden: np.ndarray, readings: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """As `Controller.respond`, for a network that may have a fault.

    It repeats the equations of `network.respond` and `Interface` in numpy: for a single robot, calling JAX at each step
    takes longer than simulating the step.
    """
    face, network = interface, jax.tree.map(np.asarray, network)
    inputs = np.clip((np.asarray(readings) - face.centre) / face.scale, -1.0, 1.0)
    one = np.ones(1)
    drives = network.w_hidden @ np.concatenate([inputs, one]) + network.w_recurrent @ np.asarray(hidden)
    hidden = np.tanh(gain * drives) * network.hidden_gain
    outputs = np.tanh(gain * (network.w_output @ np.concatenate([hidden, one])))[network.output_of]
    commands = np.clip(face.ctrl_centre + face.ctrl_scale * outputs, face.ctrl_low, face.ctrl_high)
    return hidden.astype(np.float32), commands.astype(np.float32)
