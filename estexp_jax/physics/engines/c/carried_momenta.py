"""Momentum of what each joint of lanes carries, and what follows from it: torques of gravity, mounts that give.

A joint of unit speed gives what it carries the momentum f, and n about the centre of mass of its tree. Gravity g puts
the torque f . g on it.
"""

from __future__ import annotations

from typing import final

import mujoco
import numpy as np

from estexp_jax.physics.engines.c.batches import refusals
from estexp_jax.physics.engines.c.lane_models import LaneModels
from estexp_jax.physics.model.robot import Robot

_FIRST, _MASS = slice(6, 9), slice(9, 10)
"""Columns of MuJoCo's composite inertias after the moments xx, yy, zz, xy, xz, yz: the first moment, the mass."""
_ROWS = ((0, 3, 4), (3, 1, 5), (4, 5, 2))
"""Those of the matrix of moments."""


@final
class CarriedMomenta:
    """Of each degree of freedom, in lanes' present configurations.

    Attributes:
        linear, angular: (lanes, nv, 3) f and n; 0 in lanes where nothing asks for them.
    """

    def __init__(self, models: LaneModels, lanes: np.ndarray) -> None:
        """With edited models, and the lanes (n,) where something asks for momenta: each costs a step's kinematics."""
        self._batch, self._lanes = models.batch, lanes
        self._model: mujoco.MjModel = models.batch.model
        self._gravity = models.read("opt.gravity")
        names = ("qpos", "crb", "cdof", "subtree_com", "xpos")
        self._qpos, self._composite, self._motion, self._centre, self._place = map(models.batch.bind, names)
        self.linear, self.angular = np.zeros((2, models.lanes, self._model.nv, 3))

    def update(self, qpos: np.ndarray) -> None:
        """Take configurations (lanes, nq) in."""
        self._qpos[:] = qpos
        lanes = self._lanes
        whole = lanes[np.isfinite(qpos[lanes]).all(axis=1)]
        try:
            self._batch.forward(whole, stage=int(mujoco.mjtStage.mjSTAGE_POS))
        except refusals():
            pass  # such a lane is found broken when it is stepped
        carried, motion = self._composite[lanes][:, self._model.dof_bodyid], self._motion[lanes]
        self.angular[lanes], self.linear[lanes] = _momentum(carried, motion[..., :3], motion[..., 3:])

    def gravity_torques(self) -> np.ndarray:
        """Torques of gravity (lanes, nv), N m or N."""
        return np.einsum("lie,le->li", self.linear, self._gravity)

    def mounts(self, lane: np.ndarray, body: np.ndarray, dof: np.ndarray, speed: np.ndarray) -> np.ndarray:
        """Numbers (21, n) of `MountState`, one after the other.

        Args:
            lane: (n,) index.
            body: (n,) index of the body that may give.
            dof: (n,) velocity address of something that it carries.
            speed: (n, nv), 0 of what the body does not carry.
        """
        root = self._model.body_rootid[body]
        centre, origin = self._centre[lane, root], self._place[lane, body]
        arm, whole = centre - origin, self._composite[lane, body]
        coupling = self.angular[lane] + np.cross(arm[:, None], self.linear[lane])
        momentum = np.einsum("niv,ni->nv", coupling, speed)
        index = np.arange(len(lane))
        columns = []
        for e in np.eye(3):
            n, f = _momentum(whole, e, np.cross(e, arm))
            columns.append(n + np.cross(arm, f))
        inertia = np.stack(columns, axis=1)
        six = [inertia[:, i, j] for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        first = whole[:, _FIRST] + whole[:, _MASS] * arm
        parts = (coupling[index, dof], self.linear[lane, dof], momentum, np.array(six).T, first, self._gravity[lane])
        return np.concatenate([part.T for part in parts])


def carried_dofs(robot: Robot, body: np.ndarray) -> np.ndarray:
    """1.0 where a body (n,) carries a degree of freedom, (n, nv)."""
    bodies = robot.model.dof_bodyid
    return np.array([[float(int(b) in robot.subtree(int(one))) for b in bodies] for one in body])


def _momentum(inertia: np.ndarray, spin: np.ndarray, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angular and linear momentum (..., 3) of composite inertias (..., 10) that turn and move."""
    first, mass = inertia[..., _FIRST], inertia[..., _MASS]
    turned = np.stack([np.sum(inertia[..., row] * spin, axis=-1) for row in map(list, _ROWS)], axis=-1)
    return turned + np.cross(first, speed), mass * speed - np.cross(first, spin)
