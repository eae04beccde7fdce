"""Delayed actuators and sensors on the C engine: buffers long enough for short steps, and what was commanded before.

MuJoCo keeps the last `nsample` steps of a delayed element. Steps here may be shorter than the model's own, and would
then shorten the delay with the buffer, so that it is made longer.

Source: MuJoCo documentation, "Delays".
"""

from __future__ import annotations

from collections.abc import Sequence

import mujoco
import numpy as np

from estexp_jax.physics.model.actuators import inputs_of
from estexp_jax.physics.window import Window

_SHORTER = 32
"""Steps may be so much shorter than the model's own; more than that are no more exact."""


def lengthen_histories(spec: mujoco.MjSpec) -> None:
    """Make the buffers of a description's delayed elements longer, in place; the delays stay as they are."""
    for element in (*spec.actuators, *spec.sensors):
        if element.nsample > 0:
            element.delay = min(element.delay, element.nsample * spec.option.timestep)
            element.nsample *= _SHORTER


def filled_histories(
    model: mujoco.MjModel, windows: Sequence[Window], shifts: np.ndarray, sources: np.ndarray
) -> np.ndarray | None:
    """Buffers (lanes, nhistory) with the commands before each lane's window; None where there are none.

    Sensors' buffers are as MuJoCo begins with them.

    Args:
        model: with its buffers.
        windows: of each lane.
        shifts: (lanes, nu) as of `command_routes`.
        sources: likewise.
    """
    delayed = np.flatnonzero(model.actuator_history[:, 0] > 0)
    if not delayed.size:
        return None
    data, step = mujoco.MjData(model), float(model.opt.timestep)
    found = np.empty((len(windows), model.nhistory))
    for lane, (window, shift, source) in enumerate(zip(windows, shifts, sources, strict=True)):
        for a in delayed.tolist():
            n = int(model.actuator_history[a, 0])
            before = step * np.arange(-n, 0)
            commands = window.history.mean(window.steps.start[0] + before, np.full(n, step), shift, source)
            mujoco.mj_initCtrlHistory(model, data, a, before, commands[:, inputs_of(model, a)])
        found[lane] = data.history
    return found
