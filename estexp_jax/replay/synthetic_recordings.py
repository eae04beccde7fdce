"""Recordings of a simulated robot that differs from its model in a chosen way."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import final

import mujoco
import numpy as np

from estexp_jax.discovery.export import explained_spec
from estexp_jax.errors import InputError
from estexp_jax.experiment_design.computed_torque_controller import controlled_commands, planned_path, torque_motors
from estexp_jax.experiment_design.excitation import multisine, random_steps
from estexp_jax.physics.effects.base import Effect
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.controller_fault import CommandRoute, ControllerFault
from estexp_jax.physics.effects.logging_fault import LoggingFault
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.clearance import pairs_that_touch
from estexp_jax.physics.model.portable import portable
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recordings.bind import COORDINATES, bind_columns, log_columns
from estexp_jax.recordings.table import Table
from estexp_jax.recordings.write import write_csv
from estexp_jax.replay.explained_simulator import ExplainedSimulator, Traces
from estexp_jax.runs import RunFolder, write_json, write_text
from estexp_jax.runs.model_files import write_model

_FEWEST_ROWS, _MOST_ROWS = 10, 10_000_000
"""Of a recording; the second is 14 hours at 200 rows a second."""
_FINER = 5
"""The robot is simulated at this fraction of its model's step: a real one has none."""
_SHARES = (1.0, 0.7, 0.5, 0.35, 0.25)
"""Of the usual size of motions, one after the other until no parts meet; the last one whatever they do."""


@final
@dataclass(frozen=True)
class RecordConfig:
    """How to record; the command's options have the valid ranges.

    Attributes:
        duration: of each recording, s.
        rate: rows a second.
        bits: resolution of the encoders over a turn (slides: over a metre).
        noise: deviation of the noise on positions, rad or m.
        seed: of motions and noise.
    """

    duration: float = 8.0
    rate: float = 200.0
    bits: int = 14
    noise: float = 2e-4
    seed: int = 0

    @property
    def rows(self) -> int:
        """Of each recording.

        Raises:
            InputError: far too few, or more than a log may have.
        """
        rows = int(round(self.duration * self.rate))
        if not _FEWEST_ROWS <= rows <= _MOST_ROWS:
            right = f"{_FEWEST_ROWS} to {_MOST_ROWS:,} rows"
            raise InputError(
                f"{self.duration:g} s at {self.rate:g} rows a second: {rows:,} rows", where="--duration", right=right
            )
        return rows


@final
@dataclass(frozen=True)
class RecordResult:
    """Recordings that were written.

    Attributes:
        manifest: their `recordings.toml`, which `explain` takes.
        changes: how the robot differs from its model.
    """

    manifest: Path
    changes: tuple[Change, ...]

    def summary(self) -> str:
        """How the robot differs, and where the recordings are."""
        differs = [f"The robot differs from its model: {change.sentence()}." for change in self.changes]
        return "\n".join([*differs, f"Recordings: {self.manifest}"])

    def __repr__(self) -> str:
        return self.summary()


def write_recordings(
    robot: Robot,
    changes: Sequence[Change],
    config: RecordConfig,
    folder: RunFolder,
    on_stage: Callable[[str], object] = lambda _: None,
) -> RecordResult:
    """Simulate a robot with changes, and write what it would have logged.

    Writes nominal.xml, train_0.csv, train_1.csv, test_0.csv (a larger motion), recordings.toml and truth.json. Servos
    get the positions as commands. Torque motors get the commands of a controller that moves their joints likewise. A
    robot that is bolted down moves less far where parts that do not touch at home would meet.

    Args:
        robot: the nominal one.
        changes: how the robot differs.
        config: how to record.
        folder: where the files go.
        on_stage: called with the name of what is simulated next.

    Raises:
        InputError: an effect acts in the controller, where a replay of commands does not see it; there would be far too
            few or many rows; or the simulation diverges.
    """
    for change in changes:
        if _in_controller_only(effect(change.effect)):
            what = f"'{change.effect}' acts in a controller, and commands are replayed here"
            raise InputError(what, where="--effect")
    write_model(folder, "nominal.xml", portable(explained_spec(robot, ())))
    logging = [change for change in changes if isinstance(effect(change.effect), LoggingFault)]
    real = ExplainedSimulator(robot, tuple(c for c in changes if c not in logging), _FINER)
    time = np.arange(config.rows) / config.rate
    motors = torque_motors(robot)
    motions = _motions(robot, motors, time, config)
    for i, (name, planned) in enumerate(motions):
        on_stage(f"simulating {name}")
        if motors:
            holder = controlled_commands(robot, motors, planned, 1.0 / config.rate)
            traces, commands = real.steered(holder, len(time), period=1.0 / config.rate)
        else:
            traces, commands = real.rollout(planned, period=1.0 / config.rate), planned
        _refuse_diverged(traces, name)
        columns = _log(robot, commands, traces, config, config.seed + 100 + i)
        write_csv(folder.file(name), _faulty(robot, logging, columns) if logging else columns)
    write_text(folder.file("recordings.toml"), _manifest([name for name, _ in motions]))
    write_json(folder.file("truth.json"), {"effects": [c.to_json() for c in changes], "seed": config.seed})
    return RecordResult(folder.path / "recordings.toml", tuple(changes))


def _motions(
    robot: Robot, motors: tuple[int, ...], time: np.ndarray, config: RecordConfig
) -> tuple[tuple[str, np.ndarray], ...]:
    """Names of recordings and their commands (rows, nu), as large as keeps a bolted robot's parts apart."""
    bolted = not np.any(robot.model.jnt_type == int(mujoco.mjtJoint.mjJNT_FREE))
    motions: tuple[tuple[str, np.ndarray], ...] = ()
    for share in _SHARES:
        motions = (
            ("train_0.csv", multisine(robot, time, 0.6 * share, config.seed)),
            ("train_1.csv", random_steps(robot, time, 0.6 * share, config.seed + 1)),
            ("test_0.csv", multisine(robot, time, 0.9 * share, config.seed + 2)),
        )
        paths = [planned_path(robot, motors, commands, 1.0 / config.rate) for _, commands in motions]
        if not bolted or not pairs_that_touch(robot, paths):
            break
    return motions


def _refuse_diverged(traces: Traces, name: str) -> None:
    lost = ~np.isfinite(traces.qpos).all(axis=1)
    if lost.any():
        what = f"the simulation diverges after {traces.time[int(np.argmax(lost))]:.3g} s"
        raise InputError(what, where=name, right="a smaller effect, or a model with a smaller time step")


def _in_controller_only(e: Effect) -> bool:
    return isinstance(e, ControllerFault) and not isinstance(e, CommandRoute)


def _log(robot: Robot, commands: np.ndarray, traces: Traces, config: RecordConfig, seed: int) -> dict[str, np.ndarray]:
    """Columns of a log: commands, sensors; joint coordinates where the model has no sensor at all.

    Of a free or ball joint these are its pose and its speeds, as motion capture measures them.
    """
    draw = np.random.default_rng(seed)
    columns = {"time": traces.time}
    columns |= {f"ctrl.{name}": commands[:, a] for a, name in enumerate(robot.command_columns())}
    names = robot.sensor_columns()
    if names:
        for i, name in enumerate(names):
            columns[f"sensor.{name}"] = _measured(traces.sensors[:, i], _is_position(robot, i), config, draw)
        return columns
    for joint, name in enumerate(robot.names("joint")):
        if joint in robot.scalar_joints:
            position = traces.qpos[:, robot.model.jnt_qposadr[joint]]
            columns[f"qpos.{name}"] = _measured(position, True, config, draw)
        else:
            columns |= _captured(robot, joint, traces, config, draw)
    return columns


def _faulty(robot: Robot, changes: Sequence[Change], columns: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """Columns of a log in which something went wrong when it was written."""
    recording = bind_columns(robot, Table("log", columns))
    for change in changes:
        fault = effect(change.effect)
        assert isinstance(fault, LoggingFault)
        recording = fault.logged(robot, recording, change.name or "", change.values)
    return log_columns(robot, recording)


def _captured(
    robot: Robot, joint: int, traces: Traces, config: RecordConfig, draw: np.random.Generator
) -> dict[str, np.ndarray]:
    """Columns of a free or ball joint: a pose with noise, its quaternion of length one; speeds."""
    name, kind = robot.names("joint")[joint], mujoco.mjtJoint(int(robot.model.jnt_type[joint]))
    coordinates, speeds = COORDINATES[kind]
    first, first_speed = robot.model.jnt_qposadr[joint], robot.model.jnt_dofadr[joint]
    true = traces.qpos[:, first : first + coordinates]
    pose = true + draw.normal(0.0, config.noise, true.shape)
    pose[:, -4:] /= np.linalg.norm(pose[:, -4:], axis=1, keepdims=True)
    moving = [_measured(traces.qvel[:, first_speed + i], False, config, draw) for i in range(speeds)]
    columns = {f"qpos.{name}.{i}": pose[:, i] for i in range(coordinates)}
    return columns | {f"qvel.{name}.{i}": speed for i, speed in enumerate(moving)}


def _measured(true: np.ndarray, position: bool, config: RecordConfig, draw: np.random.Generator) -> np.ndarray:
    """A reading: positions noisy and in encoder steps; others with noise of the same share of their size."""
    if position:
        step = 2.0 * np.pi / 2**config.bits
        return np.round((true + draw.normal(0.0, config.noise, true.shape)) / step) * step
    size = float(np.std(true)) or 1.0
    return true + draw.normal(0.0, config.noise, true.shape) * size


def _is_position(robot: Robot, column: int) -> bool:
    sensor = int(np.searchsorted(robot.model.sensor_adr, column, side="right")) - 1
    return int(robot.model.sensor_type[sensor]) == int(mujoco.mjtSensor.mjSENS_JOINTPOS)


def _manifest(files: Sequence[str]) -> str:
    entries = [
        f'[[recording]]\nfile = "{name}"\nrole = "{"test" if name.startswith("test") else "train"}"\n' for name in files
    ]
    return "\n".join(['model = "nominal.xml"\n', *entries])
