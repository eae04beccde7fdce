"""How large things are on a robot in ordinary motion, from one run of its nominal model: the unit of strengths."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import mujoco
import numpy as np

from experiments.benchmark.generator.excitation import controller, motion
from experiments.benchmark.generator.motors import Motors
from experiments.benchmark.generator.plant import Plant, clock
from experiments.benchmark.generator.robots import ROBOTS, layout, mass_diagonal


@dataclass(frozen=True)
class Scales:
    """Sizes in ordinary motion, of each scalar joint.

    Attributes:
        torque: root mean square of the motors' torque, or of gravity and coupling where there is no motor; N m or N.
        peak: largest torque.
        speed, amplitude: root mean squares, of the position about its mean.
        low, high: ends of the path.
        inertia: diagonal of the mass matrix at home.
    """

    torque: np.ndarray
    peak: np.ndarray
    speed: np.ndarray
    amplitude: np.ndarray
    low: np.ndarray
    high: np.ndarray
    inertia: np.ndarray


@cache
def scales(name: str) -> Scales:
    """Of a robot, from 4 s of sines (a gait) at training amplitude."""
    robot, rng = ROBOTS[name], np.random.default_rng(0)
    place, model = layout(name), robot.model
    motors = Motors.of(model, place)
    moved = motion("gait" if robot.style == "gait" else "sines", 0.6 * np.array(robot.reach), 4.0, rng)
    plant = Plant(robot, model, motors, ())
    rows = clock(4.0, 200.0, 0.0, plant.step, rng)
    trace = plant.run(controller(robot, motors, moved, "feedback", 0.6, rng), rows, None, 0.5)[1].logged()
    torque = np.zeros_like(trace.q)
    for a, j in enumerate(place.drives):
        torque[:, j] += trace.torque[:, a]
    data = mujoco.MjData(model)
    free = [j for j in range(len(place.joints)) if j not in place.drives]
    for k in range(0, len(trace.time), 4):
        data.qpos[:], data.qvel[:] = trace.qpos[k], trace.qvel[k]
        mujoco.mj_forward(model, data)
        torque[k : k + 4, free] = data.qfrc_bias[place.v[free]]
    diagonal = mass_diagonal(model, data)[place.v]
    return Scales(
        np.sqrt(np.mean(torque**2, axis=0)),
        np.abs(torque).max(axis=0),
        np.sqrt(np.mean(trace.w**2, axis=0)),
        trace.q.std(axis=0),
        trace.q.min(axis=0),
        trace.q.max(axis=0),
        diagonal,
    )
