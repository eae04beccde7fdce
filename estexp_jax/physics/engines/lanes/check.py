"""Whether lanes, as compiled here, still move a robot as MuJoCo's C engine does.

The engine depends on how XLA compiles it (see `xla.py`), so it is tried on each robot before it is believed.
"""

from __future__ import annotations

import copy

import mujoco
import numpy as np

from estexp_jax.physics.changes import neutral, stack
from estexp_jax.physics.engines.walking import Walker

_SETTLING, _ROBOTS = 30, 16
TOLERANCE = 1e-3
"""Difference of a speed that rounding to single precision explains, relative to one plus the speed."""


def disagreement(walker: Walker) -> float:
    """Relative difference of the speeds of a walker and the C engine after one control step from rest.

    The median over robots under different commands: where a foot just so touches, rounding decides whether it does, and
    two right engines part.
    """
    robot, rng = walker.robot, np.random.default_rng(0)
    values = stack([neutral(robot, walker.catalogue)] * _ROBOTS)
    weights = rng.uniform(-1.0, 1.0, (_ROBOTS, walker.n_weights))
    start = walker.settle(values, min(_SETTLING, walker.rows))
    walk = walker.walk(values, weights, start, 1)
    found = []
    for i in range(_ROBOTS):
        wanted = _in_c(walker, start.qpos[i], start.qvel[i], walk.commands[i, 0])
        found.append(np.max(np.abs(walk.final.qvel[i] - wanted) / (1.0 + np.abs(wanted))))
    return float(np.median(found))


def _in_c(walker: Walker, qpos: np.ndarray, qvel: np.ndarray, command: np.ndarray) -> np.ndarray:
    """Speeds (nv,) after one control step under a command."""
    model = copy.deepcopy(walker.on_mjx.armed)
    model.opt.iterations, model.opt.ls_iterations, model.opt.tolerance = 100, 50, 1e-12
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.ctrl[:] = qpos, qvel, command
    mujoco.mj_step(model, data, nstep=walker.substeps)
    return data.qvel.copy()
