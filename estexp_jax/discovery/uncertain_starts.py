"""What uncertain starts and lost commands do to a window's residuals, taken out of the comparison.

A window starts from a state read from noisy samples, and where a log lost a row nobody knows what was commanded. To
first order such an error adds B z to the residuals, with z standard normal and B the readings' derivatives by what is
uncertain times the square root of its covariance. Under white noise of deviation 1 the residuals' covariance is then
I + B B', and multiplying them by its inverse square root makes them white again: what a slightly other start or command
would explain counts for little, everything else in full.

Source: Rasmussen and Williams, Gaussian Processes for Machine Learning (2006), section 2.7 (parameters integrated out).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import mujoco
import numpy as np

from estexp_jax.discovery.hypotheses import Hypothesis
from estexp_jax.estimation.missing_commands import interpolation_error
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.model.scales import joint_span
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, Window

_POSITION = int(mujoco.mjtSensor.mjSENS_JOINTPOS)
_AROUND, _PER_SECOND = 0.02, 10.0
"""Of a joint's range: how far from where it was told to be it may start; and in so many ways a second."""
_MOST_LOST = 3
"""So many lost commands of a window are in doubt at most: each costs a simulation."""
_INFLATED = 2.0
"""Factor on the states' variance: jolts are smoothed away more than steady motion."""


def other_starts(model: mujoco.MjModel, segments: Sequence[Window], off: float = 1.0) -> list[list[Window]]:
    """Each segment started `off` deviations away: two copies of all of them for each degree of freedom."""
    return [
        [replace(s, start=_shifted(model, s.start, dof, k, off)) for s in segments]
        for dof in range(model.nv)
        for k in range(2)
        if any(s.start.covariance is not None and s.start.covariance[dof].any() for s in segments)
    ]


def blinded(robot: Robot, hypothesis: Hypothesis, segments: Sequence[Window]) -> Sequence[Window]:
    """Segments with starts as uncertain as a hypothesis makes them: what a stuck sensor shows tells nothing."""
    stuck = [robot.index("sensor", site) for name, site in hypothesis.places if effect(name).masks_readings]
    joints = [int(robot.model.sensor_objid[s]) for s in stuck if robot.model.sensor_type[s] == _POSITION]
    wide = {int(robot.model.jnt_dofadr[j]): 0.5 * (_AROUND * np.subtract(*joint_span(robot, j))) ** 2 for j in joints}
    return [replace(s, start=_widened(s.start, wide)) for s in segments] if wide else segments


def _widened(start: InitialState, wide: Mapping[int, float]) -> InitialState:
    if start.covariance is None:
        return start
    covariance = start.covariance.copy()
    for dof, variance in wide.items():
        covariance[dof] = variance * np.diag([1.0, _PER_SECOND**2])
    return start._replace(covariance=covariance)


def _shifted(model: mujoco.MjModel, start: InitialState, dof: int, k: int, off: float) -> InitialState:
    """A start with `off` times column `k` of the square root of its covariance added to one degree of freedom."""
    if start.covariance is None:
        return start
    spread, turn = np.linalg.eigh(_INFLATED * start.covariance[dof])
    shift = off * turn[:, k] * np.sqrt(max(spread[k], 0.0))
    qpos, qvel, move = start.qpos.copy(), start.qvel.copy(), np.zeros(model.nv)
    move[dof] = shift[0]
    mujoco.mj_integratePos(model, qpos, move, 1.0)
    qvel[dof] += shift[1]
    return start._replace(qpos=qpos, qvel=qvel)


def other_commands(recordings: Sequence[Recording], segments: Sequence[Window]) -> list[list[Window | None]]:
    """Each segment with the command of a lost row a deviation off: a copy for each of these, None where one has fewer.

    Of a segment with many lost rows only some count, those where the command changes most.
    """
    found: list[list[Window]] = [[] for _ in segments]
    spread = [interpolation_error(r) for r in recordings]
    for s, copies in zip(segments, found, strict=True):
        recording = recordings[s.recording]
        for row in _lost_rows(recording, s):
            for actuator in np.flatnonzero(spread[s.recording] > 0.0):
                ctrl = s.history.logged.copy()
                ctrl[row, actuator] += spread[s.recording][actuator]
                copies.append(replace(s, history=s.history.with_commands(ctrl)))
    most = max(map(len, found), default=0)
    return [[copies[k] if k < len(copies) else None for copies in found] for k in range(most)]


def _lost_rows(recording: Recording, s: Window) -> list[int]:
    """Rows of a segment whose commands nobody logged, at most `_MOST_LOST`."""
    if recording.guessed is None:
        return []
    rows = s.first + np.flatnonzero(recording.guessed[s.first : s.last])
    change = np.abs(recording.ctrl[rows + 1] - recording.ctrl[np.maximum(rows - 1, 0)]).max(axis=1, initial=0.0)
    return rows[np.argsort(-change, kind="stable")[:_MOST_LOST]].tolist()


def directions(effect: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Orthonormal directions in which residuals are uncertain, and what remains of residuals along them.

    Args:
        effect: (windows, samples, n) change of the residuals, in deviations of their noise, by n independent errors of
            one deviation each.

    Returns:
        Directions (windows, samples, n) and factors (windows, n) between 0 and 1.
    """
    basis, size, _ = np.linalg.svd(effect, full_matrices=False)
    return basis.astype(np.float32), 1.0 / np.sqrt(1.0 + size**2)


def whitened(residuals: np.ndarray, basis: np.ndarray, kept: np.ndarray) -> np.ndarray:
    """Residuals (members, windows, samples) with what other starts would explain scaled down, by `directions`."""
    along = np.einsum("wsn,mws->mwn", basis, residuals, optimize=True)
    return residuals - np.einsum("wsn,mwn->mws", basis, along * (1.0 - kept).astype(np.float32), optimize=True)
