"""Joint torques that a simulator lacks, from windows of some hundredths of a second.

A window starts from an estimated state and is simulated to its end. The mass matrix times what the estimated speed at
its end exceeds the simulated one, divided by the window's length, is the mean torque that the simulator lacks there.
What each effect would add is found about the same simulation under that very torque, so that it accelerates as the
robot did: otherwise any inertia would seem to make up for a missing friction. It is linear in most of what may be
missing, however large that is, since no error has time to grow.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from estexp_jax.estimation.dataset import Dataset
from estexp_jax.estimation.objective import Objective
from estexp_jax.estimation.parameters import ParameterSpace
from estexp_jax.estimation.windows import motion_of
from estexp_jax.physics.model.robot import Robot


class TorqueBalance(NamedTuple):
    """Lacking torques of windows, N m or N.

    Attributes:
        lacking: (windows, nv) at the point.
        columns: (directions, windows, nv) torque that a direction adds.
        noise: (windows, nv) standard deviation of `lacking` from uncertain states.
        scale: (nv,) root mean square of the torques that act: what motion, gravity and motors ask for.
    """

    lacking: np.ndarray
    columns: np.ndarray
    noise: np.ndarray
    scale: np.ndarray


def torque_balance(
    objective: Objective, point: np.ndarray, directions: np.ndarray, robots: Sequence[Robot]
) -> TorqueBalance:
    """Lacking torques at a point (n,), and by directions (directions, n) from it.

    Args:
        objective: its windows are short, and its outputs are states.
        point: of the parameter space.
        directions: differences from it, each as large as it is to be tried.
        robots: the nominal robot with each recording's settings.
    """
    data, model = objective.dataset, objective.space.robot.model
    last = np.array([w.rows - 1 for w in data.windows])
    at = np.arange(len(last)), last
    ends, variance = _end_speeds(data, robots)
    length = np.array([w.steps.length.sum() for w in data.windows])
    mass, acting = _mass_matrices(data, robots)
    to_torque = mass / length[:, None, None]
    speed = objective.simulate(point[None])[0][at][:, model.nq :]
    lacking = np.einsum("wij,wj->wi", to_torque, ends - speed)
    found = objective.responses(point, directions, _balanced(objective.space, lacking))
    change = found.change[:, at[0], at[1], model.nq :]
    shaken = found.initial_state[:, at[0], at[1], model.nq :]
    noise = np.einsum("wij,kwj->kwi", to_torque, shaken)
    noise = np.sqrt(np.sum(noise**2, axis=0) + np.einsum("wij,wj->wi", to_torque**2, variance))
    motion = np.einsum("wij,wj->wi", to_torque, ends - np.array([w.start.qvel for w in data.windows]))
    scale = np.sqrt(np.mean(motion**2 + acting**2, axis=0))
    return TorqueBalance(lacking, np.einsum("wij,kwj->kwi", to_torque, change), noise, scale)


def _balanced(space: ParameterSpace, lacking: np.ndarray) -> np.ndarray:
    """Differences (windows, n) of the points under which each window's lacking torques act on its joints."""
    found, model = np.zeros((len(lacking), len(space.parameters))), space.robot.model
    offset = next(e for e in space.catalogue if e.is_constant_torque)
    for site in offset.sites(space.robot):
        [index] = space.of_place[offset.name, site]
        found[:, index] = lacking[:, model.jnt_dofadr[space.robot.index("joint", site)]]
    return found


def _end_speeds(data: Dataset, robots: Sequence[Robot]) -> tuple[np.ndarray, np.ndarray]:
    """Estimated speeds (windows, nv) at the windows' last rows, and their variances."""
    speeds, variances = [], []
    for w in data.windows:
        motion = motion_of(robots[w.recording], data.recordings[w.recording])
        speeds.append(motion.trajectory.qvel[w.last])
        variances.append(motion.covariance[w.last, :, 1, 1])
    return np.array(speeds), np.array(variances)


def _mass_matrices(data: Dataset, robots: Sequence[Robot]) -> tuple[np.ndarray, np.ndarray]:
    """Mass matrices (windows, nv, nv) at the windows' starts, and sizes (windows, nv) of the torques there."""
    masses, acting = [], []
    holders = {id(r): mujoco.MjData(r.model) for r in robots}
    for w in data.windows:
        model, at = robots[w.recording].model, holders[id(robots[w.recording])]
        at.qpos[:], at.qvel[:], at.ctrl[:] = w.start.qpos, w.start.qvel, w.logged[0]
        mujoco.mj_forward(model, at)
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, at, full)
        masses.append(full)
        acting.append(np.hypot(at.qfrc_bias, at.qfrc_actuator))
    return np.array(masses), np.array(acting)
