"""Readings of faulty sensors, after a replay."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache

import jax
import numpy as np

from estexp_jax.physics.effects.base import Distortion
from estexp_jax.physics.effects.changes import Values
from estexp_jax.physics.effects.registry import Catalogue
from estexp_jax.physics.engines.c.instances import at_work
from estexp_jax.physics.model.robot import Robot

_ROWS = 4096
"""Rows of readings in a call, so that programs of one length serve all."""
_PROGRAMS = 128


def distort_readings(robot: Robot, catalogue: Catalogue, values: Values, sensors: np.ndarray) -> None:
    """Put the faults of sensors into readings (steps, nsensordata, lanes), in place, in the catalogue's order."""
    for e in catalogue:
        if not isinstance(e, Distortion):
            continue
        own = np.asarray(values[e.name])
        lanes = np.flatnonzero(at_work(e, own).any(axis=1))
        if lanes.size:
            true = np.moveaxis(sensors[:, :, lanes], 1, 2)
            filled = np.broadcast_to(own[lanes].astype(float), (len(true), *own[lanes].shape))
            faulty = _distorted(robot, e, true.reshape(-1, true.shape[2]), filled.reshape(-1, *own.shape[1:]))
            sensors[:, :, lanes] = np.moveaxis(faulty.reshape(true.shape), 2, 1)


def _distorted(robot: Robot, e: Distortion, rows: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Faulty rows (n, nsensordata) of true ones."""
    program, found = _program(robot, e), np.empty_like(rows)
    with jax.enable_x64(True):
        for first in range(0, len(rows), _ROWS):
            index = np.minimum(np.arange(first, first + _ROWS), len(rows) - 1)
            found[first : first + _ROWS] = np.asarray(program(rows[index], values[index]))[: len(rows) - first]
    return found


@lru_cache(maxsize=_PROGRAMS)
def _program(robot: Robot, e: Distortion) -> Callable[[np.ndarray, np.ndarray], jax.Array]:
    return jax.jit(jax.vmap(lambda readings, values: e.distort(robot, readings, values)))
