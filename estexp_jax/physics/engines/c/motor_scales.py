"""Motors of lanes that are switched off, or scaled by what acts on them."""

from __future__ import annotations

from copy import copy
from typing import final

import mujoco
import numpy as np

from estexp_jax.physics.engines.c.lane_models import LaneModels
from estexp_jax.physics.model.actuators import affine_actuators

_UNLIMITED = 1e20
"""Force limit of a motor without one."""


@final
class MotorScales:
    """Gains, biases and force limits of lanes' motors, which are written only where they change."""

    def __init__(self, models: LaneModels) -> None:
        """With edited models."""
        self._models, model = models, models.batch.model
        self._odd = np.flatnonzero(~affine_actuators(model))
        names = ("actuator_gainprm", "actuator_biasprm", "actuator_forcerange")
        self._gain, self._bias, self._range = (np.array(models.read(name)) for name in names)
        self._limited = np.array(models.read("actuator_forcelimited")).astype(bool)
        self._on = self._share = np.ones(self._gain.shape[:2])

    def write(self, on: np.ndarray, share: np.ndarray | None) -> None:
        """Switch motors on or off (lanes, motors), 1.0 or 0.0, and scale their forces by shares; None: as they were.

        Gain, bias and force range are scaled together, so that limits scale with the force. Motors of other kinds than
        fixed and affine have numbers that are no factors; off, their force range is zero.
        """
        share = self._share if share is None else share
        if np.array_equal(on, self._on) and np.array_equal(share, self._share):
            return
        own, scale = self._models.own, (on * share)[:, :, None]
        own("actuator_gainprm")[:] = self._gain * scale
        own("actuator_biasprm")[:] = self._bias * scale
        limits = self._range * share[:, :, None]
        if self._odd.size:
            odd = self._odd
            free = np.where(self._limited[:, odd, None], limits[:, odd], (-_UNLIMITED, _UNLIMITED))
            limits[:, odd] = free * on[:, odd, None]
            own("actuator_forcelimited")[:, odd] = 1
            own("actuator_gainprm")[:, odd] = self._gain[:, odd]
            own("actuator_biasprm")[:, odd] = self._bias[:, odd]
        own("actuator_forcerange")[:] = limits
        self._on, self._share = on.copy(), share.copy()


def with_switched_motors(model: mujoco.MjModel, on: np.ndarray) -> mujoco.MjModel:
    """A copy of a model with motors on or off, (nactuator,) 1.0 or 0.0; as `MotorScales`."""
    other, affine = copy(model), affine_actuators(model)
    other.actuator_gainprm[affine] *= on[affine, None]
    other.actuator_biasprm[affine] *= on[affine, None]
    off = ~affine & (on == 0.0)
    other.actuator_forcelimited[off], other.actuator_forcerange[off] = 1, 0.0
    return other
