"""Position of a robot's root as a function of its configuration alone."""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import mujoco
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.model.robot import Robot

_FREE, _SLIDE = int(mujoco.mjtJoint.mjJNT_FREE), int(mujoco.mjtJoint.mjJNT_SLIDE)


def root_position(robot: Robot) -> Callable[[jax.Array], jax.Array]:
    """The map from a configuration (nq,) to the root's position (3,), m.

    The root is the body with the first free joint, or else the first moving body, which then has to slide.

    Raises:
        InputError: the root can neither float nor slide, so no distance is defined.
    """
    matrix, offset = root_position_map(robot)
    return lambda qpos: jnp.asarray(matrix, jnp.float32) @ qpos + jnp.asarray(offset, jnp.float32)


def root_position_map(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Matrix (3, nq) and offset (3,) of the map in `root_position`."""
    model = robot.model
    matrix, offset = np.zeros((3, model.nq)), np.zeros(3)
    free = [j for j in range(model.njnt) if int(model.jnt_type[j]) == _FREE]
    if free:
        address = int(model.jnt_qposadr[free[0]])
        matrix[:, address : address + 3] = np.eye(3)
        return matrix, offset
    first = int(model.jnt_bodyid[0]) if model.njnt else 0
    slides = [j for j in range(model.njnt) if int(model.jnt_bodyid[j]) == first and int(model.jnt_type[j]) == _SLIDE]
    if not slides:
        raise InputError(
            "this robot cannot travel: its root neither floats nor slides",
            where=robot.source,
            right="give the root body a freejoint",
        )
    rotation = np.zeros(9)
    mujoco.mju_quat2Mat(rotation, model.body_quat[first])
    for joint in slides:
        matrix[:, int(model.jnt_qposadr[joint])] = rotation.reshape(3, 3) @ model.jnt_axis[joint]
    return matrix, model.body_pos[first] - matrix @ model.qpos0
