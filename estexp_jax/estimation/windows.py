"""Division of recordings into consecutive windows without overlap."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import lru_cache
from typing import NamedTuple

import mujoco
import numpy as np

from estexp_jax.estimation.initial_state import EstimatedMotion, estimate_motion
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import Window, command_history_of, window_of

FINER = 4
"""The finest timestep of fitted windows is the model's own divided by this."""
_STRIDE = 0.4
"""Longest fitted window of a floating robot that touches the ground, s."""


class WindowSet(NamedTuple):
    """The same windows at the model's own timestep, at half of it, and at a fraction 1 / `parts` of it.

    The finest approximate continuous time; the others show the integration error.
    """

    whole: tuple[Window, ...]
    half: tuple[Window, ...]
    fine: tuple[Window, ...]
    parts: int = FINER

    def finer(self, steps: Sequence[float], parts: int) -> WindowSet:
        """The same windows with another finest timestep.

        Args:
            steps: the model's own timestep in each recording, s.
            parts: divisor of these for the finest.
        """
        fine = tuple(s.stepped(steps[s.recording] / parts) for s in self.whole)
        return self._replace(fine=fine, parts=parts)

    def exact(self) -> WindowSet:
        """All windows at the finest timestep."""
        return WindowSet(self.fine, self.fine, self.fine, self.parts)


def window_rows(time: np.ndarray, length: float, cut: float | None = None) -> list[tuple[int, int]]:
    """First and last row of each window of a clock; a lone row joins the one before, or the one after.

    Args:
        time: (rows,) s.
        length: of a window, s; infinite for one window.
        cut: time of a further window boundary, s.
    """
    number = np.zeros(len(time), int) if np.isinf(length) else ((time - time[0]) / length + 1e-9).astype(int)
    if cut is not None:
        number = 2 * number + (time >= cut)
    firsts = [int(np.flatnonzero(number == n)[0]) for n in np.unique(number)]
    lasts = [f - 1 for f in firsts[1:]] + [len(time) - 1]
    windows: list[tuple[int, int]] = []
    for first, last in zip(firsts, lasts, strict=True):
        if windows and (first == last or windows[-1][0] == windows[-1][1]):
            windows[-1] = (windows[-1][0], last)
        else:
            windows.append((first, last))
    return windows


def fitting_window(robot: Robot, longest: float) -> float:
    """Length of fitted windows, s: shorter for robots that are sensitive to their initial state.

    After a stride, a slightly earlier touchdown has changed the motion too much for parameters to be identified.

    Args:
        robot: the nominal robot.
        longest: length of the evaluated windows, s.
    """
    return min(longest, _STRIDE) if is_sensitive_to_start(robot) else longest


def is_sensitive_to_start(robot: Robot) -> bool:
    """Whether small differences of the initial state soon grow: true for floating robots with contacts."""
    floats = bool((robot.model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE)).any())
    touches = bool((robot.model.geom_contype | robot.model.geom_conaffinity).any())
    return floats and touches


@lru_cache(maxsize=64)
def motion_of(robot: Robot, recording: Recording) -> EstimatedMotion:
    """`estimate_motion`, cached for all windows and timesteps of a recording."""
    return estimate_motion(robot, recording)


def windows_of(
    robots: Sequence[Robot],
    recordings: Sequence[Recording],
    length: float,
    finer: int = 1,
    cuts: Mapping[int, float] | None = None,
) -> list[Window]:
    """All windows of all recordings, each with the state estimated at its first row.

    Args:
        robots: the nominal robot with each recording's settings.
        recordings: one for each robot.
        length: of a window, s; infinite for whole recordings.
        finer: divisor of the model's timestep.
        cuts: maps the index of a recording to the time of a further window boundary in it, s.
    """
    found: list[Window] = []
    for i, (robot, recording) in enumerate(zip(robots, recordings, strict=True)):
        motion, step = motion_of(robot, recording), float(robot.model.opt.timestep) / finer
        history = command_history_of(recording, motion.trajectory)
        for rows in window_rows(recording.time, length, (cuts or {}).get(i)):
            found.append(window_of(recordings, i, rows, step, motion.state_at(rows[0]), motion.trajectory, history))
    return found


def window_set_of(
    robots: Sequence[Robot],
    recordings: Sequence[Recording],
    length: float,
    cuts: Mapping[int, float] | None = None,
) -> WindowSet:
    """`windows_of` at all timesteps."""
    whole, half, fine = (tuple(windows_of(robots, recordings, length, finer, cuts)) for finer in (1, 2, FINER))
    return WindowSet(whole, half, fine)
