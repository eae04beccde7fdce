"""How arms are driven, and how visible each effect is: by how much the readings would differ without it."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from experiments.explain.several.arms import HELD, RATE, Arm, Motion
from experiments.explain.several.real import RealArm, Run

Controller = Callable[[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]
"""(wanted position, speed, acceleration, reading, speed) -> command."""
_STIFFNESS, _DAMPING = 100.0, 20.0
"""Of the controllers: a natural frequency of 10 rad/s, squared, and twice it."""
_WINDOWS = 2
"""Windows of 1 s a recording in which effects are left out."""


def controller(arm: Arm, computed: bool) -> Controller:
    """One that knows the nominal arm: its servos, its whole dynamics (computed torque), or its inertias and weights."""
    model, data = arm.model, mujoco.MjData(arm.model)

    def servos(p: np.ndarray, *_: np.ndarray) -> np.ndarray:
        return p

    def torques(p: np.ndarray, s: np.ndarray, a: np.ndarray, q: np.ndarray, w: np.ndarray) -> np.ndarray:
        wanted = _STIFFNESS * (p - q) + _DAMPING * (s - w)
        data.qpos[:], data.qvel[:], data.qacc[:] = q, w if computed else 0.0, a + wanted if computed else 0.0
        mujoco.mj_inverse(model, data)
        asked = data.qfrc_inverse if computed else data.qfrc_bias + arm.inertia * wanted
        return np.clip(asked, model.actuator_ctrlrange[:, 0], model.actuator_ctrlrange[:, 1])

    return servos if arm.servo else torques


def driven(real: RealArm, motion: Motion, control: Controller) -> Run:
    """Let a real arm make a motion; the rows before it begins, in which the arm is held, come too."""
    rows, n = motion.position.shape
    command, position, speed, reading = (np.zeros((rows, n)) for _ in range(4))
    real.begin(motion.position[0], motion.speed[0], np.zeros(0))
    states = []
    for k in range(rows):
        position[k], speed[k] = real.data.qpos[real.q], real.data.qvel[real.v]
        reading[k] = real.reading()
        states.append(real.mount())
        wanted = (motion.position[k], motion.speed[k], motion.acceleration[k])
        command[k] = control(*wanted, reading[k], speed[k])
        real.row(command, k)
    return Run(command, position, speed, np.array(states), reading)


def change(other: RealArm, runs: Sequence[Run]) -> float:
    """By how much (rad, root mean square) another arm's readings differ in windows that begin at the same readings."""
    total, length = [], round(RATE)
    for run in runs:
        held = round(HELD * RATE)
        most = (len(run.command) - held) // length
        for i in np.unique(np.linspace(0, most - 1, _WINDOWS).round().astype(int)):
            first = held + i * length
            other.begin(run.reading[first] - other.values["bias"], run.speed[first], run.state[first])
            for k in range(first, first + length):
                total.append(other.reading() - run.reading[k])
                other.row(run.command, k)
    return float(np.sqrt(np.mean(np.square(total))))
