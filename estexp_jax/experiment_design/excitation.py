"""Excitation: commands that move a robot in many ways, to record when nothing is known yet."""

from __future__ import annotations

from collections.abc import Callable

import mujoco
import numpy as np

from estexp_jax.physics.model.actuators import (
    actuator_of_input,
    affine_actuators,
    gear_of,
    inputs_of,
    position_input,
)
from estexp_jax.physics.model.robot import Robot

_SINES = 5
_SLOWEST, _FASTEST = 0.15, 2.0
"""Frequencies of the sines, Hz."""
_REACH = 0.6
"""Amplitude of a servo about home where no range limits it, rad."""

Wave = Callable[[np.ndarray, np.random.Generator], np.ndarray]
"""Maps times (rows,) and a random generator to a signal (rows,) in -1..1 that begins at 0."""


def multisine(robot: Robot, time: np.ndarray, strength: float, seed: int) -> np.ndarray:
    """Sums of sines at random frequencies and phases, one for each actuator, from home.

    Args:
        robot: the nominal one.
        time: (rows,) s.
        strength: peak, as a share of each actuator's range.
        seed: of frequencies and phases.

    Returns:
        Commands (rows, nu), in each actuator's control unit.
    """
    return _commands(robot, time, strength, seed, sines)


def random_steps(robot: Robot, time: np.ndarray, strength: float, seed: int) -> np.ndarray:
    """Random levels held for 0.4 to 1.2 s, reached by ramps of 0.2 s; arguments and result as of `multisine`."""
    return _commands(robot, time, strength, seed, random_levels)


def sines(time: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    """A sum of sines (rows,) with its peak at 1 or -1, from 0."""
    hertz = np.exp(draw.uniform(np.log(_SLOWEST), np.log(_FASTEST), _SINES))
    phase = draw.uniform(0.0, 2.0 * np.pi, _SINES)
    waves = np.sin(2.0 * np.pi * hertz * time[:, None] + phase).sum(axis=1)
    waves -= waves[0] * np.exp(-(time - time[0]) / 0.3)
    return waves / np.abs(waves).max()


def random_levels(time: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    """Random levels (rows,) in -1..1 held for 0.4 to 1.2 s, reached by ramps of 0.2 s."""
    edges = time[0] + np.cumsum(draw.uniform(0.4, 1.2, int(np.ptp(time) / 0.4) + 2))
    heights = draw.uniform(-1.0, 1.0, len(edges))
    knots = np.stack([edges, edges + 0.2], axis=1).ravel()
    ends = np.stack([np.concatenate([[0.0], heights[:-1]]), heights], axis=1).ravel()
    return np.interp(time, knots, ends)


def ramps(time: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    """Slow ramps (rows,) between 1 and -1, once or twice: they show effects that do not depend on speed."""
    sweeps, sign = int(draw.integers(1, 3)), float(draw.choice([-1.0, 1.0]))
    knots = time[0] + np.ptp(time) * np.linspace(0.0, 1.0, 4 * sweeps + 1)
    return sign * np.interp(time, knots, np.tile([0.0, 1.0, 0.0, -1.0], sweeps + 1)[: len(knots)])


def ramp_and_hold(time: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    """One level (rows,) in -1..1, reached by a ramp of 1 s: it shows creep and sag."""
    return float(draw.uniform(-1.0, 1.0)) * np.clip(time - time[0], 0.0, 1.0)


def _commands(robot: Robot, time: np.ndarray, strength: float, seed: int, wave: Wave) -> np.ndarray:
    draw = np.random.default_rng(seed)
    centre, reach = excitation_range(robot)
    commands = np.empty((len(time), robot.model.nu))
    for a in range(robot.model.nu):
        commands[:, a] = centre[a] + strength * reach[a] * wave(time, draw)
    return commands


def excitation_range(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Centre and amplitude of each actuator's commands, (nu,) each, in its unit.

    Servos go from home to the nearer end of their range, motors to their force limit.
    """
    model, home = robot.model, robot.home()
    centre, reach = np.zeros(model.nu), np.ones(model.nu)
    affine = affine_actuators(model)
    for k, a in enumerate(actuator_of_input(model).tolist()):
        joint = robot.joint_of_actuator(a)
        if k == position_input(model, a) and joint in robot.scalar_joints:
            centre[k] = home[model.jnt_qposadr[joint]] * gear_of(model, a)
            reach[k] = _REACH
        elif affine[a] and model.actuator_forcelimited[a]:
            reach[k] = np.abs(model.actuator_forcerange[a]).max() / max(abs(model.actuator_gainprm[a, 0]), 1e-9)
        elif int(model.actuator_trntype[a]) == int(mujoco.mjtTrn.mjTRN_SO3):
            centre[k], reach[k] = float(_is_real_part(model, k, a)), _REACH
        if model.actuator_ctrllimited[k]:
            low, high = model.actuator_ctrlrange[k]
            if not low < centre[k] < high:
                centre[k] = (low + high) / 2.0
            reach[k] = min(reach[k], high - centre[k], centre[k] - low)
    return centre, reach


def _is_real_part(model: mujoco.MjModel, command: int, actuator: int) -> bool:
    """Whether a command of an orientation servo is the real part of a quaternion."""
    is_quaternion = int(model.actuator_ctrlspec[actuator]) == int(mujoco.mjtCtrlChart.mjCHART_QUAT)
    return is_quaternion and command == inputs_of(model, actuator)[0]
