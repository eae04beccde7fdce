"""A controller as plain arrays, for a computer without the simulator.

One control step, u_k being the inputs, h_k the hidden neurons (h_-1 = 0), c_k the commands:

    u_k = clip((readings - centre) / scale, -1, 1)
    h_k = tanh(gain (w_hidden [u_k, 1] + w_recurrent h_k-1))
    c_k = clip(ctrl_centre + ctrl_scale tanh(gain w_output [h_k, 1]), ctrl_low, ctrl_high)

Source: Bongard and Lipson 2004, section 2.2 and Figure 4; see `recovery.control.network`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from estexp_jax.recovery.control.network import HIDDEN, Network
from estexp_jax.recovery.control.trial import Controller, Scales, controller_step

_NETWORK = ("w_hidden", "w_recurrent", "w_output")
_OTHERS = ("inputs", "is_touch", "rest", "actuators", "gain", "control_step", "steps", "weights")
ARRAYS = (*_NETWORK, *Scales._fields, *_OTHERS)
"""Names of the arrays in a controller's file."""


@final
@dataclass(frozen=True, eq=False)
class OnboardController:
    """A controller without a simulator; its file has the same names.

    Attributes:
        w_hidden: (3, n_inputs + 1) weights of the hidden neurons, of the inputs and, last, the bias.
        w_recurrent: (3, 3) of the hidden neurons, of their own outputs one step before.
        w_output: (n_outputs, 4) of the outputs, of the hidden neurons and, last, the bias.
        scales: six arrays in the file: `centre`, `scale` (n_inputs,) of the readings, in their unit; `ctrl_centre`,
            `ctrl_scale`, `ctrl_low`, `ctrl_high` (n_outputs,) of the commands, in each actuator's unit.
        inputs: (n_inputs,) names of the sensors, in the order of the readings.
        is_touch: (n_inputs,) whether it is a touch sensor, which reads +1 (contact) or -1, not a force.
        rest: (n_inputs,) the reading of a sensor that is lost.
        actuators: (n_outputs,) names, in the order of the commands.
        gain: of the neurons' tanh.
        control_step: time between two commands, s.
        steps: commands of a trial.
        weights: (n_weights,) the genome, which contains the three tables.
    """

    w_hidden: np.ndarray
    w_recurrent: np.ndarray
    w_output: np.ndarray
    scales: Scales
    inputs: tuple[str, ...]
    is_touch: np.ndarray
    rest: np.ndarray
    actuators: tuple[str, ...]
    gain: float
    control_step: float
    steps: int
    weights: np.ndarray

    @classmethod
    def of(cls, controller: Controller, actuators: Sequence[str]) -> OnboardController:
        """A controller of a robot with these actuators."""
        network, face = controller.network(), controller.interface
        return cls(
            w_hidden=np.asarray(network.w_hidden),
            w_recurrent=np.asarray(network.w_recurrent),
            w_output=np.asarray(network.w_output),
            scales=Scales(*(np.asarray(getattr(face, name), float) for name in Scales._fields)),
            inputs=face.names,
            is_touch=face.is_touch,
            rest=face.rest,
            actuators=tuple(actuators),
            gain=controller.gain,
            control_step=controller.control_step,
            steps=controller.steps,
            weights=controller.weights,
        )

    def hidden(self) -> np.ndarray:
        """Hidden outputs (3,) before the first step."""
        return np.zeros(HIDDEN, np.float32)

    def respond(self, hidden: np.ndarray, readings: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """One control step.

        Args:
            hidden: (3,) of the step before; `hidden()` at first.
            readings: (n_inputs,) in the order of `inputs`: rad, m, or +1 and -1 for touch.

        Returns:
            Hidden outputs (3,) for the next step, and commands (n_outputs,) in the order of `actuators`.
        """
        healthy = np.ones(HIDDEN, np.float32), np.arange(len(self.w_output))
        tables: Any = (self.w_hidden, self.w_recurrent, self.w_output, *healthy)
        return controller_step(Network(*tables), self.scales, self.gain, hidden, readings)

    def to_arrays(self) -> dict[str, np.ndarray]:
        """The arrays of its file, named as in `ARRAYS`."""
        named = {name: getattr(self, name) for name in (*_NETWORK, *_OTHERS)}
        return {name: np.asarray(value) for name, value in (named | self.scales._asdict()).items()}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, np.ndarray]) -> OnboardController:
        """The inverse of `to_arrays`.

        Raises:
            KeyError: an array is missing.
            ValueError: the shapes do not match.
        """
        n, m = len(arrays["inputs"]), len(arrays["actuators"])
        shapes = {"w_hidden": (HIDDEN, n + 1), "w_recurrent": (HIDDEN, HIDDEN), "w_output": (m, HIDDEN + 1)}
        shapes |= {name: (m if name.startswith("ctrl_") else n,) for name in Scales._fields}
        shapes |= dict.fromkeys(("is_touch", "rest"), (n,))
        for name, shape in shapes.items():
            if arrays[name].shape != shape:
                raise ValueError(f"{name} is {arrays[name].shape}, not {shape}")
        return cls(
            scales=Scales(*(arrays[name] for name in Scales._fields)),
            inputs=tuple(str(name) for name in arrays["inputs"]),
            actuators=tuple(str(name) for name in arrays["actuators"]),
            gain=float(arrays["gain"]),
            control_step=float(arrays["control_step"]),
            steps=int(arrays["steps"]),
            **{name: arrays[name] for name in (*_NETWORK, "is_touch", "rest", "weights")},
        )
