"""Momentum of what each joint carries, on MJX, and what follows from it: torques of gravity, mounts that give.

A joint of unit speed gives what it carries the momentum f, and n about the centre of mass of its tree. Gravity g puts
the torque f . g on it.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import jax.numpy as jnp
import numpy as np
from mujoco import mjx

from estexp_jax.physics.effects.mounts import MountState
from estexp_jax.physics.model.robot import Robot

_ROWS = np.array(((0, 3, 4), (3, 1, 5), (4, 5, 2)))
"""Columns of MuJoCo's composite inertias: the matrix of moments; after them the first moment, and the mass."""


class CarriedMomentum(NamedTuple):
    """Of each degree of freedom (nv, 3), with MJX's numbers of the configuration."""

    linear: Any
    angular: Any
    data: Any


def carried_momentum(robot: Robot, model: mjx.Model, qpos: Any) -> CarriedMomentum:
    """Of one robot in a configuration (nq,)."""
    placed = mjx.kinematics(model, mjx.make_data(robot.model).replace(qpos=qpos))
    data: Any = mjx.crb(model, mjx.com_pos(model, placed))
    motion = data.cdof
    angular, linear = _momentum(data._impl.crb[robot.model.dof_bodyid], motion[:, :3], motion[:, 3:])
    return CarriedMomentum(linear, angular, data)


def torques_of_weight(robot: Robot, model: mjx.Model, qpos: Any) -> Any:
    """Torque of gravity (nv,) on each degree of freedom, N m or N, in a configuration (nq,)."""
    return carried_momentum(robot, model, qpos).linear @ model.opt.gravity


def mount_states(
    robot: Robot, model: mjx.Model, bodies: np.ndarray, dofs: np.ndarray, qpos: Any, qvel: Any
) -> MountState:
    """Bodies (n,) that may give, each with one degree of freedom (n,) that it carries; state (nq,), (nv,)."""
    carried = carried_momentum(robot, model, qpos)
    data, inside = carried.data, np.array([robot.subtree(int(b)) for b in bodies], dtype=object)
    there = np.array([np.isin(robot.model.dof_bodyid, part) for part in inside], float).reshape(len(bodies), -1)
    arm = data.subtree_com[robot.model.body_rootid[bodies]] - data.xpos[bodies]
    coupling = carried.angular + jnp.cross(arm[:, None], carried.linear)
    whole, columns = data._impl.crb[bodies], []
    for e in np.eye(3):
        n, f = _momentum(whole, jnp.asarray(e), jnp.cross(jnp.asarray(e), arm))
        columns.append(n + jnp.cross(arm, f))
    six = [columns[j][:, i] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
    xx, yy, zz, xy, xz, yz = six
    return MountState(
        _parts(coupling[np.arange(len(bodies)), dofs]),
        _parts(carried.linear[dofs]),
        _parts(jnp.einsum("niv,ni->nv", coupling, there * qvel)),
        (xx, yy, zz, xy, xz, yz),
        _parts(whole[:, 6:9] + whole[:, 9:] * arm),
        _parts(jnp.broadcast_to(model.opt.gravity, arm.shape)),
    )


def _parts(vectors: Any) -> tuple[Any, Any, Any]:
    return vectors[:, 0], vectors[:, 1], vectors[:, 2]


def _momentum(inertia: Any, spin: Any, speed: Any) -> tuple[Any, Any]:
    """Angular and linear momentum (n, 3) of composite inertias (n, 10) that turn and move."""
    first, mass = inertia[:, 6:9], inertia[:, 9:]
    turned = jnp.sum(inertia[:, _ROWS] * spin[..., None, :], axis=-1)
    return turned + jnp.cross(first, speed), mass * speed - jnp.cross(first, spin)
