"""Commands that move a robot in many ways: what to record when nothing is known yet."""

from __future__ import annotations

import mujoco
import numpy as np

from estexp_jax.physics.robot import Robot

_SINES = 5
_SLOWEST, _FASTEST = 0.15, 2.0
"""Frequencies of the sines, Hz."""
_REACH = 0.6
"""Of a servo, from home, where no range limits it: rad."""


def multisine(robot: Robot, time: np.ndarray, strength: float, seed: int) -> np.ndarray:
    """Sums of sines at random frequencies and phases, one sum for each actuator; they begin at home.

    Args:
        robot: whose actuators.
        time: (rows,) s.
        strength: share of each actuator's reach that the sum's peak takes.
        seed: of frequencies and phases.

    Returns:
        Commands (rows, nu), in each actuator's control unit.
    """
    draw = np.random.default_rng(seed)
    centre, reach = command_reach(robot)
    commands = np.empty((len(time), robot.model.nu))
    for a in range(robot.model.nu):
        hertz = np.exp(draw.uniform(np.log(_SLOWEST), np.log(_FASTEST), _SINES))
        phase = draw.uniform(0.0, 2.0 * np.pi, _SINES)
        waves = np.sin(2.0 * np.pi * hertz * time[:, None] + phase).sum(axis=1)
        waves -= waves[0] * np.exp(-(time - time[0]) / 0.3)
        commands[:, a] = centre[a] + strength * reach[a] * waves / np.abs(waves).max()
    return commands


def steps(robot: Robot, time: np.ndarray, strength: float, seed: int) -> np.ndarray:
    """Random levels held for 0.4 to 1.2 s, reached by ramps of 0.2 s; arguments and result as of `multisine`."""
    draw = np.random.default_rng(seed)
    centre, reach = command_reach(robot)
    commands = np.empty((len(time), robot.model.nu))
    for a in range(robot.model.nu):
        edges = time[0] + np.cumsum(draw.uniform(0.4, 1.2, int(np.ptp(time) / 0.4) + 2))
        levels = draw.uniform(-1.0, 1.0, len(edges))
        knots = np.stack([edges, edges + 0.2], axis=1).ravel()
        heights = np.stack([np.concatenate([[0.0], levels[:-1]]), levels], axis=1).ravel()
        commands[:, a] = centre[a] + strength * reach[a] * np.interp(time, knots, heights)
    return commands


def command_reach(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Centre and largest sensible deviation of each actuator's command, (nu,) each.

    Servos go from home to the nearer end of their range; motors to their limit.
    """
    model, home = robot.model, robot.home()
    centre, reach = np.zeros(model.nu), np.ones(model.nu)
    for a in range(model.nu):
        joint = robot.joint_of_actuator(a)
        servo = model.actuator_biastype[a] != mujoco.mjtBias.mjBIAS_NONE and model.actuator_biasprm[a, 1] != 0.0
        if servo and joint in robot.scalar_joints:
            centre[a] = home[model.jnt_qposadr[joint]] * model.actuator_gear[a, 0]
            reach[a] = _REACH
        elif model.actuator_forcelimited[a]:
            reach[a] = np.abs(model.actuator_forcerange[a]).max() / max(abs(model.actuator_gainprm[a, 0]), 1e-9)
        if model.actuator_ctrllimited[a]:
            low, high = model.actuator_ctrlrange[a]
            if not low < centre[a] < high:
                centre[a] = (low + high) / 2.0
            reach[a] = min(reach[a], high - centre[a], centre[a] - low)
    return centre, reach
