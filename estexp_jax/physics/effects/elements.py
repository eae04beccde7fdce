"""The elements on which an effect acts during a step: its sites, or all those that one site stands for.

A site may stand for several elements: `*` for all of its kind alike, beside each one's own, the environment for all
motors, a body for all joints that it carries. Engines act on elements; values are given at sites.
"""

from __future__ import annotations

from typing import Any

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.effect import Effect
from estexp_jax.physics.effects.mounts import carried_joints
from estexp_jax.physics.effects.sites import ALL_ALIKE, actuator_sites
from estexp_jax.physics.model.robot import Robot

_ENVIRONMENT = ("",)


def elements_of(effect: Effect, robot: Robot) -> tuple[str, ...]:
    """Names of the joints or actuators on which an effect acts; of one of the environment, all driven actuators."""
    sites = effect.sites(robot)
    if effect.kind == "body":
        return tuple(joint for body in sites for joint in carried_joints(robot, body))
    return actuator_sites(robot) if sites == _ENVIRONMENT else tuple(s for s in sites if s != ALL_ALIKE)


def site_rows(effect: Effect, robot: Robot) -> np.ndarray:
    """Index of the site whose values each element has, (n_elements,); `*` left out."""
    sites = effect.sites(robot)
    if effect.kind == "body":
        return np.repeat(np.arange(len(sites)), [len(carried_joints(robot, body)) for body in sites])
    n = len(elements_of(effect, robot))
    return np.zeros(n, int) if sites == _ENVIRONMENT else np.arange(n)


def element_values(effect: Effect, robot: Robot, values: Any) -> Any:
    """Values (..., n_elements, n_parameters) at elements, of values (..., n_sites, n_parameters) at sites.

    Of an element with values of its own beside the common ones, the distances from neutral add up.
    """
    sites = effect.sites(robot)
    if sites == _ENVIRONMENT or effect.kind == "body":
        return values[..., site_rows(effect, robot), :]
    if ALL_ALIKE not in sites:
        return values
    own, alike = values[..., :-1, :], values[..., -1:, :]
    neutral = np.array([p.neutral for p in effect.parameters], values.dtype)
    where: Any = np.where if isinstance(values, np.ndarray) else jnp.where
    # Not simply added: a neutral value may be so large that single precision loses the rest.
    return where(own == neutral, alike, own + where(alike == neutral, 0.0, alike - neutral))
