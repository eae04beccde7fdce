"""States from which engines are compared with plain MuJoCo: at rest, saturated, at joint limits, moving, recorded."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import mujoco
import numpy as np

from estexp_jax.physics.model import scales
from estexp_jax.physics.model.actuators import actuator_of_input, position_input
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.window import Window

EVERY = 23
"""Physics steps between two visited states under one command."""
WALK = 16
"""States visited before the robot starts again from home, so that not all lie on their backs."""
_MOVING, _SPECIAL, _RECORDED = 12, 6, 8
"""States of each kind: passed through under random commands; special ones; of recordings."""
_BEYOND = 2.0
"""Commands without a range, for saturation: so many times those that give a motor its largest torque."""


class Probes(NamedTuple):
    """States and commands; the first axis counts them.

    Attributes:
        kind: what is special about each.
        qpos, qvel: (n, nq), (n, nv).
        ctrl: (n, nu) from now on.
        before: (n, steps, nu) in each of the steps until now: as many as the robot's delays remember, at least one.
    """

    kind: tuple[str, ...]
    qpos: np.ndarray
    qvel: np.ndarray
    ctrl: np.ndarray
    before: np.ndarray


def probes_of(robot: Robot, windows: Sequence[Window] = (), seed: int = 0) -> Probes:
    """States of a robot in which engines may differ.

    Args:
        robot: as it was in the first recording.
        windows: of recordings, whose starts are among the states.
        seed: of random commands.
    """
    rng = np.random.default_rng(seed)
    home, still = robot.home(), np.zeros(robot.model.nv)
    low, high = command_limits(robot)
    rows: list[tuple[str, np.ndarray, np.ndarray, np.ndarray]] = []
    middle = np.clip(_idle(robot), low, high)
    rows += [("at rest", home, still, ctrl) for ctrl in (middle, np.clip(np.zeros_like(low), low, high), middle)]
    ends = [low, high, *(np.where(rng.random(low.size) < 0.5, low, high) for _ in range(_SPECIAL - 2))]
    moving = list(wandered(robot, lambda: rng.uniform(low, high), 2 * _MOVING))
    rows += [("moving", *state, rng.uniform(low, high)) for state in moving[:_MOVING]]
    rows += [("saturated", *state, end) for state, end in zip(moving[_MOVING:], ends, strict=False)]
    rows += [("at joint limits", *state, rng.uniform(low, high)) for state in _at_limits(robot, moving, rng)]
    chosen = [windows[i] for i in np.unique(np.linspace(0, len(windows) - 1, _RECORDED).astype(int))] if windows else []
    rows += [("recorded", w.start.qpos, w.start.qvel, w.logged[0]) for w in chosen]
    kind, *states = zip(*rows, strict=True)
    qpos, qvel, ctrl = (np.array(x, np.float32).astype(float) for x in states)
    remembered = max(1, int(robot.model.actuator_history[:, 0].max(initial=0)))
    before = rng.uniform(low, high, (len(kind), remembered, len(low))).astype(np.float32).astype(float)
    return Probes(kind, qpos, qvel, ctrl, before)


def command_limits(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest command (nu,): the range, else what saturates the motor."""
    model = robot.model
    reach = np.array([_BEYOND * _reach(robot, k) for k in range(model.nu)])
    limited = model.actuator_ctrllimited.astype(bool)
    low, high = model.actuator_ctrlrange.T
    return np.where(limited, low, -reach), np.where(limited, high, reach)


def _reach(robot: Robot, command: int) -> float:
    actuator = int(actuator_of_input(robot.model)[command])
    reach = scales.command_reach(robot, actuator)
    return reach if np.isfinite(reach) and reach > 0.0 else 1.0


def _idle(robot: Robot) -> np.ndarray:
    """Commands (nu,) of a robot at home: positions are held, all else is nothing."""
    model, home, found = robot.model, robot.home(), np.zeros(robot.model.nu)
    for k, a in enumerate(actuator_of_input(model).tolist()):
        joint = robot.joint_of_actuator(a)
        if joint in robot.scalar_joints and k == position_input(model, a):
            found[k] = home[model.jnt_qposadr[joint]]
    return found


def wandered(robot: Robot, commands: Callable[[], np.ndarray], n: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Configurations and speeds that a robot passes through in MuJoCo under random commands; finite ones alone."""
    model, data = robot.model, mujoco.MjData(robot.model)
    found = []
    for k in range(n):
        if k % WALK == 0 or not np.isfinite(data.qvel).all():
            mujoco.mj_resetData(model, data)
            data.qpos[:] = robot.home()
        data.ctrl[:] = commands()
        mujoco.mj_step(model, data, EVERY)
        if np.isfinite(data.qpos).all() and np.isfinite(data.qvel).all():
            found.append((data.qpos.copy(), data.qvel.copy()))
    return found


def _at_limits(
    robot: Robot, visited: Sequence[tuple[np.ndarray, np.ndarray]], rng: np.random.Generator
) -> list[tuple[np.ndarray, np.ndarray]]:
    """Visited states with limited joints at the ends of their ranges, or a little beyond, moving outwards."""
    model, found = robot.model, []
    joints = [j for j in robot.scalar_joints if model.jnt_limited[j]]
    for qpos, qvel in visited[:_SPECIAL] if joints else ():
        qpos, qvel = qpos.copy(), qvel.copy()
        for j in joints:
            side = int(rng.integers(2))
            outwards = 1.0 if side else -1.0
            qpos[model.jnt_qposadr[j]] = model.jnt_range[j, side] + outwards * 0.01 * np.ptp(model.jnt_range[j])
            qvel[model.jnt_dofadr[j]] = outwards * abs(qvel[model.jnt_dofadr[j]])
        found.append((qpos, qvel))
    return found
