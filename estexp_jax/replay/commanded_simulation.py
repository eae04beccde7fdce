"""Commands of a log, replayed through the model as it is."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.command_schedule import CommandHistory
from estexp_jax.physics.effects.changes import encode, stack
from estexp_jax.physics.effects.registry import named_effects
from estexp_jax.physics.engines.choice import open_loop_simulator
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.physics.window import InitialState, window_of
from estexp_jax.recordings.bind import column_names

GivenState = tuple[object, object] | InitialState | Mapping[str, object]
"""A state: (qpos, qvel), or by these names."""


def simulate_commands(
    robot: Robot, commands: Recording, start: GivenState | None, engine: str
) -> dict[str, np.ndarray]:
    """Replay a recording's commands through a robot's model.

    Args:
        robot: as modelled.
        commands: its time, commands and switches count; its readings do not.
        start: state at the first row; None: that of the columns `qpos.*` and `qvel.*` there, else home and at rest.
        engine: auto, lanes, c or mjx. A single robot is soonest on c, which auto takes.

    Returns:
        `time`, `sensor.*`, `qpos.*`, `qvel.*`: each (rows,), at the row's time, before the row's command acts. Before
        the first row commands are 0, as MuJoCo has them after a reset.

    Raises:
        InputError: the state does not fit the robot, fewer than two rows, or the engine does not simulate the model.
    """
    if len(commands.time) < 2:
        raise InputError("fewer than two rows are no motion", where=commands.name)
    begin = _recorded_start(robot, commands) if start is None else _given_start(robot, start)
    history = CommandHistory(commands.time, commands.ctrl, np.zeros(robot.model.nu))
    rows, step = (0, len(commands.time) - 1), float(robot.model.opt.timestep)
    window = window_of([commands], 0, rows, step, begin, history=history)
    effects = named_effects()[:1]  # a catalogue needs one; it stays neutral
    simulator = open_loop_simulator(robot, effects, [robot], engine="c" if engine == "auto" else engine, width=1)
    found = simulator.replay(stack([encode(robot, effects, ())]), [window], np.zeros(1, int))
    traces = {"time": commands.time.copy()}
    for kind, values in (("sensor", found.sensors), ("qpos", found.qpos), ("qvel", found.qvel)):
        names = [name for name in column_names(robot) if name.startswith(f"{kind}.")]
        traces |= dict(zip(names, values[0].astype(float).T, strict=True))
    return traces


def _recorded_start(robot: Robot, commands: Recording) -> InitialState:
    """Home and at rest, but for what the first row says."""
    home, still = robot.home(), np.zeros(robot.model.nv)
    qpos, qvel = commands.qpos[0], commands.qvel[0]
    return InitialState(np.where(np.isfinite(qpos), qpos, home), np.where(np.isfinite(qvel), qvel, still))


def _given_start(robot: Robot, start: GivenState) -> InitialState:
    sizes = {"qpos": robot.model.nq, "qvel": robot.model.nv}
    right = f"qpos of {sizes['qpos']} and qvel of {sizes['qvel']} numbers"
    given = start if isinstance(start, Mapping) else dict(zip(sizes, start, strict=False))
    unknown = [name for name in given if name not in sizes]
    if unknown:
        raise InputError(f"has no part '{unknown[0]}'", where="start", right=right)
    values = {"qpos": robot.home(), "qvel": np.zeros(robot.model.nv)}
    for name, value in given.items():
        try:
            array = np.asarray(value, float)
        except (TypeError, ValueError):
            raise InputError(f"{name} is no list of numbers", where="start", right=right) from None
        if array.shape != (sizes[name],) or not np.isfinite(array).all():
            raise InputError(f"{name} is not {sizes[name]} finite numbers", where="start", right=right)
        values[name] = array
    return InitialState(**values)
