"""How robots are moved: reference motions, and what turns them into commands."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from experiments.benchmark.generator.motors import Motors
from experiments.benchmark.generator.plant import Controller
from experiments.benchmark.generator.robots import Robot, home, layout

Motion = Callable[[float], np.ndarray]
"""Reference of each scalar joint around home, rad or m, at a time."""

KINDS = ("sines", "steps", "chirp", "ramps")
"""Motions of fixed-base robots."""


def motion(kind: str, reach: np.ndarray, seconds: float, rng: np.random.Generator) -> Motion:
    """A motion of the given kind with peaks of about `reach` (joints,)."""
    makers = {"sines": _sines, "steps": _steps, "chirp": _chirp, "ramps": _ramps, "gait": _gait}
    return makers[kind](reach, seconds, rng)


def _sines(reach: np.ndarray, seconds: float, rng: np.random.Generator) -> Motion:
    f, p = rng.uniform(0.2, 2.2, (4, len(reach))), rng.uniform(0.0, 2.0 * np.pi, (4, len(reach)))
    return lambda t: reach / 2.4 * np.sin(2.0 * np.pi * f * t + p).sum(axis=0)


def _steps(reach: np.ndarray, seconds: float, rng: np.random.Generator) -> Motion:
    changes = np.cumsum(rng.uniform(0.4, 1.2, 60)) - 2.0
    levels = rng.uniform(-1.0, 1.0, (61, len(reach))) * reach
    return lambda t: levels[np.searchsorted(changes, t)]


def _chirp(reach: np.ndarray, seconds: float, rng: np.random.Generator) -> Motion:
    last, p = rng.uniform(2.0, 3.5, len(reach)), rng.uniform(0.0, 2.0 * np.pi, len(reach))
    return lambda t: reach * np.sin(2.0 * np.pi * (0.2 * t + (last - 0.2) * t * t / (2.0 * seconds)) + p) * 0.8


def _ramps(reach: np.ndarray, seconds: float, rng: np.random.Generator) -> Motion:
    period, p = rng.uniform(1.5, 3.5, len(reach)), rng.uniform(0.0, 1.0, len(reach))
    return lambda t: reach * (4.0 * np.abs((t / period + p) % 1.0 - 0.5) - 1.0)


def _gait(reach: np.ndarray, seconds: float, rng: np.random.Generator) -> Motion:
    f, trot = rng.uniform(0.8, 1.6), np.repeat([0.0, np.pi, np.pi, 0.0], 2)
    lag, own = np.tile([0.0, rng.uniform(0.8, 2.0)], 4), rng.uniform(-0.3, 0.3, 8)
    size = reach * rng.uniform(0.4, 0.8, 8)
    return lambda t: size * np.sin(2.0 * np.pi * f * t + trot + lag + own) * min(1.0, max(0.0, t + 1.0))


def controller(
    robot: Robot, motors: Motors, moved: Motion, kind: str, size: float, rng: np.random.Generator
) -> Controller:
    """What asks for a motion: positions of servos; of motors torques, by feedback on the true state plus a dither.

    Args:
        robot: which.
        motors: of its *nominal* model.
        moved: the motion.
        kind: `open` gives motors the motion's shape as torque, without feedback.
        size: amplitude as a share of the full one.
        rng: of the dither.
    """
    place = layout(robot.name)
    rest = home(robot.model)[place.q]
    f, p = rng.uniform(0.5, 4.0, (3, len(rest))), rng.uniform(0.0, 2.0 * np.pi, (3, len(rest)))
    limit = [min(h, u) for h, u in zip(motors.high, motors.most, strict=True)]

    def commands(t: float, q: list[float], w: list[float]) -> list[float]:
        goal = moved(t)
        noise = np.sin(2.0 * np.pi * f * t + p).sum(axis=0)
        out = []
        for a, j in enumerate(place.drives):
            reach = robot.reach[j]
            if motors.stiffness[a]:
                u = rest[j] + goal[j]
            elif kind == "open":
                u = 0.15 * limit[a] * goal[j] / reach
            else:
                u = (
                    limit[a] / reach * (0.7 * (rest[j] + goal[j] - q[j]) - 0.07 * w[j])
                    + 0.04 * size * limit[a] * noise[j]
                )
            out.append(
                float(min(max(u, -limit[a], motors.least[a]), limit[a], motors.most[a]))
                if not motors.stiffness[a]
                else float(u)
            )
        return out

    return commands
