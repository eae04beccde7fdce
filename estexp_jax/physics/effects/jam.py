"""The damping of a joint that jams: what a jam adds to it, and where viscous friction ends and a jam begins."""

from __future__ import annotations

import numpy as np

from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

JAMMED = 0.5
"""Degree of a jam from which on damping is called one; below, it is viscous friction."""
_STUCK_SPEED = np.deg2rad(1.0)


def jam_damping(robot: Robot, site: str, f: float) -> float:
    """Damping added by a jam of degree f: geometric, from nominal to 'full torque moves it 1 degree a second'."""
    joint = robot.index("joint", site)
    start, full = jam_range(robot, joint)
    return (start * (full / start) ** f - start) if f > 0.0 else 0.0


def jam_range(robot: Robot, joint: int) -> tuple[float, float]:
    """Damping at f = 0, the nominal one (or a small one, where there is none), and at f = 1, stuck."""
    nominal = float(robot.model.dof_damping[robot.model.jnt_dofadr[joint]])
    full = scales.joint_torque(robot, joint) / _STUCK_SPEED
    return (nominal, max(full, nominal)) if nominal > 0.0 else (1e-4 * full, full)
