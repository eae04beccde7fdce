"""`simulate`: commands replayed through a model."""

from __future__ import annotations

from pathlib import Path

import mujoco
import numpy as np

from estexp_jax.api.options.keywords import front_door
from estexp_jax.errors import InputError
from estexp_jax.physics.model.given import ModelLike, robot_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.bind import bind_columns, read_recording
from estexp_jax.recordings.frames import Frame, Logs, frame_table, logs_of
from estexp_jax.replay.commanded_simulation import GivenState, simulate_commands


@front_door()
def simulate(
    model: ModelLike,
    commands: Logs,
    *,
    start: GivenState | None = None,
    engine: str = "auto",
    root: str | Path | None = None,
) -> dict[str, np.ndarray]:
    """Replay commands through a model, as it is.

    Args:
        model: path of an MJCF or URDF, a description, a compiled model, or a robot.
        commands: a log: a path, a data frame, a dictionary of arrays, with columns `time`, `ctrl.*` and, where motors
            are switched, `enable.*`.
        start: the state (qpos, qvel) at the first row; None: that of the columns `qpos.*` and `qvel.*` there, else the
            home keyframe and at rest.
        engine: auto, lanes, c or mjx; auto takes c, MuJoCo itself, which is soonest for a single robot.
        root: folder under which the model finds its files; None: the repository or package around it, else three up.

    Returns:
        Arrays (rows,) `time`, `sensor.*`, `qpos.*`, `qvel.*` at those times, taken before the row's command acts.

    Raises:
        InputError: a keyword, the model, a column or the state is wrong, or the engine does not simulate the model.
    """
    robot = _robot(model, root, engine)
    logs = logs_of(commands, "commands")
    if len(logs) != 1:
        raise InputError(f"{len(logs)} logs", where="simulate()", right="one log of commands")
    (log,) = logs
    if isinstance(log, Frame):
        recording = bind_columns(robot, frame_table(log), commands_alone=True)
    else:
        recording = read_recording(robot, log, commands_alone=True)
    return simulate_commands(robot, recording, start, engine)


def _robot(model: ModelLike, root: str | Path | None, engine: str) -> Robot:
    if isinstance(model, mujoco.MjModel):
        if engine in ("lanes", "mjx"):
            right = "engine c; or its MJCF"
            raise InputError(f"a compiled model cannot be taken to {engine}", where="simulate()", right=right)
        return Robot(mujoco.MjSpec(), model, "MjModel")
    return robot_of(model, root)
