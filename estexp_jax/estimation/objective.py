"""From parameters to residuals: windows simulated under many hypotheses at once, and their derivatives.

One batch of simulations gives the residuals at a point, along any number of directions from it, and under uncertain
initial states.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple, final

import mujoco
import numpy as np

from estexp_jax.estimation.dataset import Dataset
from estexp_jax.estimation.parameters import ParameterSpace
from estexp_jax.estimation.windows import FINER
from estexp_jax.physics.engines.open_loop import OpenLoopRollout, OpenLoopSimulator
from estexp_jax.physics.window import Window

_MOST_LANES = 4096
"""Robots simulated together, to bound memory."""
_DIVERGED = 1e6
"""A reading beyond this is a simulation that diverged."""


class Responses(NamedTuple):
    """Simulated windows at a point and what changes along directions from it.

    Attributes:
        point: (windows, rows, outputs).
        change: (directions, windows, rows, outputs) simulated at the direction's end, less `point`.
        initial_state: (2 nv, windows, rows, outputs) likewise for initial states one standard deviation off.
    """

    point: np.ndarray
    change: np.ndarray
    initial_state: np.ndarray


@final
@dataclass(frozen=True, eq=False)
class Objective:
    """A simulator and the windows that it is compared with.

    Attributes:
        simulator: of the robot and the catalogue.
        space: of the same.
        dataset: the windows.
        states: whether outputs are the states (qpos, qvel) instead of the channels' readings.
        step_error: (windows, rows, outputs) added to all that is simulated, as of `without_step_error`.
        counted: robot steps simulated so far, a list of one number.
    """

    simulator: OpenLoopSimulator
    space: ParameterSpace
    dataset: Dataset
    states: bool = False
    step_error: np.ndarray | float = 0.0
    counted: list[int] = field(default_factory=lambda: [0])

    def with_dataset(self, dataset: Dataset, *, states: bool = False) -> Objective:
        """The same simulator compared with other windows."""
        return replace(self, dataset=dataset, states=states, step_error=0.0)

    def without_step_error(self, point: np.ndarray, share: float = 1.0) -> Objective:
        """The same, with outputs as they would be at no time step at all, by what a finer one changes at a point (n,).

        A step of some milliseconds damps a robot by itself, which would pass for friction or delay.

        Args:
            point: of the parameter space.
            share: of the step's error that is taken out; a robot that was itself simulated has some of it.

        Source: Richardson, Philosophical Transactions of the Royal Society A 210 (1911).
        """
        plain, step = replace(self, step_error=0.0), float(self.space.robot.model.opt.timestep)
        windows = tuple(w.stepped(step / FINER) for w in self.dataset.windows)
        finer = replace(plain, dataset=replace(self.dataset, windows=windows))
        change = finer.simulate(point[None])[0] - plain.simulate(point[None])[0]
        high_order = int(self.space.robot.model.opt.integrator) == int(mujoco.mjtIntegrator.mjINT_RK4)
        change = np.where(np.abs(change) < _DIVERGED, change, 0.0)
        return replace(self, step_error=share * change * (1.0 if high_order else FINER / (FINER - 1)))

    def simulate(self, points: np.ndarray, of_window: np.ndarray | float = 0.0) -> np.ndarray:
        """Outputs (points, windows, rows, outputs) at points (points, n), NaN beyond a window's end.

        Args:
            points: of the parameter space.
            of_window: (windows, n) added to every point in each window.
        """
        n = len(self.dataset.windows)
        found = []
        for part in _parts(points, n):
            every = (part[:, None, :] + of_window) + np.zeros((1, n, 1))
            found.append(self._outputs(every.reshape(len(part) * n, -1), self.dataset.windows, _each(len(part), n)))
        whole = np.concatenate(found)
        return whole.reshape(len(points), n, *whole.shape[1:]) + self.step_error

    def responses(
        self,
        point: np.ndarray,
        directions: np.ndarray,
        of_window: np.ndarray | float = 0.0,
        *,
        initial_states: bool = True,
    ) -> Responses:
        """Outputs at a point (n,) and at its sum with each of directions (directions, n); `of_window` as above."""
        whole = self.simulate(np.concatenate([point[None], point + directions]), of_window)
        whole = np.where(np.abs(whole) < _DIVERGED, whole, np.where(np.isnan(whole), np.nan, _DIVERGED))
        shaken = self._shaken(point, of_window) if initial_states else np.zeros((0, *whole.shape[1:]))
        return Responses(whole[0], whole[1:] - whole[0], shaken + self.step_error - whole[0])

    def _shaken(self, point: np.ndarray, of_window: np.ndarray | float) -> np.ndarray:
        """Outputs (2 nv, windows, rows, outputs) from initial states one standard deviation off in each way."""
        windows = other_initial_states(self.space.robot.model, self.dataset.windows)
        flat = [w for copies in windows for w in copies]
        found, n = [], len(self.dataset.windows)
        points = np.tile(point + of_window + np.zeros((n, 1)), (len(windows), 1))
        for begin in range(0, len(flat), _MOST_LANES):
            part = flat[begin : begin + _MOST_LANES]
            found.append(self._outputs(points[begin : begin + len(part)], part, np.arange(len(part))))
        whole = np.concatenate(found)
        return whole.reshape(len(windows), n, *whole.shape[1:])

    def _outputs(self, points: np.ndarray, windows: Sequence[Window], which: np.ndarray) -> np.ndarray:
        rollout = self.simulator.replay(self.space.values(points), windows, which)
        steps = np.array([w.steps.n_steps for w in windows])
        self.counted[0] += int(steps[which].sum())
        found = _states(rollout) if self.states else self.dataset.channels.simulated(rollout)
        missing = max(w.rows for w in self.dataset.windows) - found.shape[1]
        return np.pad(found.astype(np.float64), [(0, 0), (0, missing), (0, 0)], constant_values=np.nan)


def other_initial_states(model: mujoco.MjModel, windows: Sequence[Window]) -> list[list[Window]]:
    """The windows from initial states one standard deviation off: 2 nv copies of all, two for each degree of freedom.

    Along the principal axes of the covariance of its position and speed.
    """
    return [[_moved(model, w, dof, k) for w in windows] for dof in range(model.nv) for k in range(2)]


def _moved(model: mujoco.MjModel, window: Window, dof: int, k: int) -> Window:
    start = window.start
    if start.covariance is None or not start.covariance[dof].any():
        return window
    variance, axes = np.linalg.eigh(start.covariance[dof])
    shift = axes[:, k] * np.sqrt(max(variance[k], 0.0))
    qpos, qvel, move = start.qpos.copy(), start.qvel.copy(), np.zeros(model.nv)
    move[dof] = shift[0]
    mujoco.mj_integratePos(model, qpos, move, 1.0)
    qvel[dof] += shift[1]
    return replace(window, start=start._replace(qpos=qpos, qvel=qvel))


def _states(rollout: OpenLoopRollout) -> np.ndarray:
    return np.concatenate([rollout.qpos, rollout.qvel], axis=2)


def _each(points: int, windows: int) -> np.ndarray:
    """Index of each lane's window, all windows of one point after the other."""
    return np.tile(np.arange(windows), points)


def _parts(points: np.ndarray, windows: int) -> list[np.ndarray]:
    most = max(1, _MOST_LANES // max(windows, 1))
    return [points[i : i + most] for i in range(0, len(points), most)]
