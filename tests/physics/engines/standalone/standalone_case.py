"""Robots stepped by an `explained.py` that is imported as users would, beside this package's own simulator."""

from __future__ import annotations

import copy
import importlib.util
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

from estexp_jax.physics.effects.changes import Change, encode, stack
from estexp_jax.physics.effects.registry import catalogue, every
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.engines.open_loop import OpenLoopRollout
from estexp_jax.physics.engines.standalone.script import explained_script
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, window_of


def imported(
    folder: Path, robot: Robot, changes: Sequence[tuple[Change, bool]], finer: int = 1, file: Any = None
) -> Any:
    """The module of an `explained.py`, which finds nothing of this package."""
    path = folder / "explained.py"
    path.write_text(explained_script(robot, changes, finer, file), encoding="utf-8")
    assert "estexp_jax" not in path.read_text(encoding="utf-8")
    spec = importlib.util.spec_from_file_location("explained", path)
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    sys.modules["explained"] = module
    spec.loader.exec_module(module)
    return module


def commands(robot: Robot, rows: int) -> tuple[np.ndarray, np.ndarray]:
    """Commands (rows, nu), and switches (rows, nactuator): motors are off for a while."""
    t, nu = np.arange(rows) * robot.model.opt.timestep, robot.model.nu
    on = np.ones((rows, robot.model.nactuator))
    on[rows // 2 : rows // 2 + 8] = 0.0
    return 0.8 * np.sin(2.0 * np.pi * 3.0 * t[:, None] + np.arange(nu)), on


def by_engine(
    robot: Robot, changes: Sequence[Change], ctrl: np.ndarray, on: np.ndarray, finer: int = 1
) -> OpenLoopRollout:
    """What this package's C engine says, a row a step."""
    model, rows = robot.model, len(ctrl)
    sensor, qpos, qvel = (np.full((rows, n), np.nan) for n in (model.nsensordata, model.nq, model.nv))
    step = float(model.opt.timestep)
    recording = Recording("steps", step * np.arange(rows), ctrl, on, sensor, qpos, qvel)
    start = InitialState(robot.home(), np.zeros(model.nv))
    window = window_of([recording], 0, (0, rows - 1), step / finer, start)
    wanted = {c.effect for c in changes}
    effects = catalogue(e.name for e in every() if e.name in wanted)
    simulator = open_loop_simulator(robot, effects, [robot], engine="c")
    return simulator.replay(stack([encode(robot, effects, changes)]), [window], np.array([0]))


def by_script(
    module: Any, model: mujoco.MjModel, start: np.ndarray, ctrl: np.ndarray, on: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Positions and readings (rows, ...) of one robot, a row a step."""
    model = copy.copy(model)
    data, qpos, readings = mujoco.MjData(model), [], []
    data.qpos[: len(start)] = start
    module.install(model, data)
    for u, switched in zip(ctrl, on, strict=True):
        qpos.append(data.qpos.copy())
        data.ctrl[:] = u
        module.step(model, data, switched)
        readings.append(data.sensordata.copy())
        assert np.array_equal(data.ctrl, u) and not data.qfrc_applied.any(), "what others write is left to them"
    return np.array(qpos), np.array(readings)


def by_batch(
    module: Any, model: mujoco.MjModel, start: np.ndarray, ctrl: np.ndarray, on: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The same of the second of two robots in a batch; the first is commanded otherwise."""
    from mujoco.batch import Batch  # MuJoCo 4

    batch, qpos, readings = Batch(model, 2, nthread=1), [], []
    places, given = batch.bind("qpos"), batch.bind("ctrl")
    places[:] = start
    module.install(batch.model, batch)
    for u, switched in zip(ctrl, on, strict=True):
        qpos.append(places[1].copy())
        given[:] = [0.0 * u, u]
        readings.append(module.step(batch.model, batch, switched)[1])
    return np.array(qpos), np.array(readings)
