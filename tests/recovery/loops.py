"""Trials of a robot that nobody simulates: smooth readings, and what a random controller answers."""

import numpy as np

from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.physics.recording import Recording
from estexp_jax.recovery.control.network import n_weights
from estexp_jax.recovery.control.trial import Controller, Trial

STEPS, PERIOD = 60, 0.01


def controller_of(robot: Robot, seed: int = 0) -> Controller:
    face = interface_of(robot)
    weights = np.random.default_rng(seed).uniform(-1.0, 1.0, n_weights(face.n_inputs, face.n_outputs))
    return Controller(weights.astype(np.float32), face, 3.0, PERIOD, STEPS)


def readings_at(controller: Controller, time: np.ndarray, phase: float = 0.0) -> np.ndarray:
    """Readings (rows, n_inputs): slow waves, touch by their sign."""
    face = controller.interface
    waves = 0.4 * np.sin(6.0 * time[:, None] + np.arange(face.n_inputs) + phase)
    return np.where(face.is_touch, np.where(waves > 0.0, 1.0, -1.0), waves)


def walked(controller: Controller, phase: float = 0.0) -> Trial:
    """In closed loop; the root goes 2 m/s along x."""
    time = controller.control_step * np.arange(controller.steps)
    readings, commands, hidden = readings_at(controller, time, phase), [], controller.rest()
    for row in readings:
        hidden, command = controller.respond(hidden, row)
        commands.append(command)
    position = np.stack([2.0 * time, 0.1 * time, np.full(len(time), 0.3)], axis=1)
    return Trial(time, readings, np.stack(commands), position)


def columns_of(robot: Robot, controller: Controller, trial: Trial) -> dict[str, np.ndarray]:
    """The trial as the columns of a file."""
    motors, root = robot.names("actuator"), robot.names("joint")[0]
    columns = {"time": trial.time}
    columns |= {f"ctrl.{name}": c for name, c in zip(motors, trial.commands.T, strict=True)}
    columns |= {f"sensor.{name}": c for name, c in zip(controller.interface.names, trial.readings.T, strict=True)}
    return columns | {f"qpos.{root}.{k}": c for k, c in enumerate(trial.position.T)}


def recorded(robot: Robot, controller: Controller, trial: Trial, time: np.ndarray | None = None) -> Recording:
    """The trial as its logger saw it, at the same control steps or at rows of other times."""
    model = robot.model
    time = trial.time if time is None else time
    often = len(time) > len(trial.time)
    row = np.floor(time / PERIOD + 1e-9) if often else np.round(time / PERIOD)
    row = np.clip(row.astype(int), 0, len(trial.time) - 1)
    sensor, qpos = np.full((len(time), model.nsensordata), np.nan), np.full((len(time), model.nq), np.nan)
    sensor[:, controller.interface.columns] = readings_at(controller, time)
    qpos[:, :3] = np.stack([2.0 * time, 0.1 * time, np.full(len(time), 0.3)], axis=1)
    shape = (len(time), model.nv)
    return Recording(
        "trial_0.csv",
        time + 5.0,
        trial.commands[row],
        np.ones_like(trial.commands[row]),
        sensor,
        qpos,
        np.full(shape, np.nan),
    )
