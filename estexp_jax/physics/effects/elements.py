"""The elements on which an effect acts during a step: its sites, or all those that one site stands for.

A site may stand for several elements: `*` for all of its kind alike, beside each one's own, and the environment for
all motors. Engines act on elements; values are given at sites.
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.effect import Effect
from estexp_jax.physics.effects.sites import ALL_ALIKE, actuator_sites
from estexp_jax.physics.model.robot import Robot

_ENVIRONMENT = ("",)


def elements_of(effect: Effect, robot: Robot) -> tuple[str, ...]:
    """Names of the joints or actuators on which an effect acts; of one of the environment, all driven actuators."""
    sites = effect.sites(robot)
    return actuator_sites(robot) if sites == _ENVIRONMENT else tuple(s for s in sites if s != ALL_ALIKE)


def element_values(effect: Effect, robot: Robot, values: Any) -> Any:
    """Values (..., n_elements, n_parameters) at elements, of values (..., n_sites, n_parameters) at sites.

    Of an element with values of its own beside the common ones, the distances from neutral add up.
    """
    sites = effect.sites(robot)
    if sites == _ENVIRONMENT:
        return values[..., np.zeros(len(elements_of(effect, robot)), int), :]
    if ALL_ALIKE not in sites:
        return values
    own, alike = values[..., :-1, :], values[..., -1:, :]
    neutral = np.array([p.neutral for p in effect.parameters], values.dtype)
    where: Any = np.where if isinstance(values, np.ndarray) else jnp.where
    # Not simply added: a neutral value may be so large that single precision loses the rest.
    return where(own == neutral, alike, own + where(alike == neutral, 0.0, alike - neutral))
