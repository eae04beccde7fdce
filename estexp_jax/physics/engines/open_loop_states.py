"""States of open-loop lanes between blocks of steps, and their readings at the beginning of steps."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import mujoco
import numpy as np

from estexp_jax.physics.engines.open_loop_inputs import equal_commands
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.window import Window

_Array = Any
"""A NumPy array outside the compiled function, a JAX array inside."""


class LaneBatchState(NamedTuple):
    """Lanes between two blocks: arrays (lanes, ...), and hidden variables as an engine keeps them."""

    qpos: _Array
    qvel: _Array
    act: _Array
    warmstart: _Array
    hidden: Any  # as the engine keeps it


class StepReadings(NamedTuple):
    """Readings and states of lanes at the beginning of steps, (steps, ..., lanes)."""

    sensors: np.ndarray
    qpos: np.ndarray
    qvel: np.ndarray


def at_rows(x: np.ndarray, windows: Sequence[Window], rows: int) -> np.ndarray:
    """Columns (lanes, rows, columns) at the rows of windows, from those (steps, columns, lanes) at all steps.

    NaN beyond a window's last row.
    """
    found = np.full((len(windows), rows, x.shape[1]), np.nan, x.dtype)
    for i, there in equal_commands(windows, np.ones(len(windows), bool)):
        sample = windows[i].steps.sample
        found[there, : len(sample)] = np.moveaxis(x[sample, :, there], -1, 0)
    return found


def shows_forces(robot: Robot) -> bool:
    """Whether a robot has a sensor of forces or accelerations: a row's command would show there, were it in force."""
    return bool(np.any(robot.model.sensor_needstage == int(mujoco.mjtStage.mjSTAGE_ACC)))
