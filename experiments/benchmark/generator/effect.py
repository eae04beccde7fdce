"""What an effect may do, and the moment it does it in."""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field
from math import exp

import mujoco
import numpy as np

from experiments.benchmark.generator.motors import Motors
from experiments.benchmark.generator.robots import Layout


@dataclass
class Moment:
    """One fine step of a robot, as effects see it; lists are changed in place.

    Attributes:
        t: time, s.
        dt: the fine step, s; 0: only look, no hidden state moves on.
        q, w: position and speed of each scalar joint.
        command: of each actuator, in force.
        error: what each actuator acts on.
        torque: of each actuator, at its joint.
        force: on each scalar joint.
    """

    t: float
    dt: float
    q: list[float]
    w: list[float]
    command: list[float]
    error: list[float] = field(default_factory=list)
    torque: list[float] = field(default_factory=list)
    force: list[float] = field(default_factory=list)


class Effect:
    """Something the nominal simulator lacks; does nothing unless a method is replaced.

    Attributes:
        parameters: by name, SI.
        start: time at which it sets in, s.
    """

    def __init__(self, parameters: Mapping[str, float], layout: Layout, at: int, motors: Motors) -> None:
        """At the joint, actuator or body of an index; -1: everywhere."""
        self.parameters, self.layout, self.at, self.motors, self.start = dict(parameters), layout, at, motors, 0.0
        self.begin()

    def __getattr__(self, name: str) -> float:
        """A parameter by its name."""
        try:
            return self.__dict__["parameters"][name]
        except KeyError:
            raise AttributeError(name) from None

    def begin(self) -> None:
        """Set hidden states to their values at rest."""

    def edit(self, model: mujoco.MjModel) -> None:
        """Change the true model before anything moves."""

    def command(self, m: Moment) -> None:
        """Change the commands on their way to the motors."""

    def act(self, m: Moment) -> None:
        """Change what the motors act on."""

    def motor(self, m: Moment) -> None:
        """Change the motors' torques."""

    def transmit(self, m: Moment) -> None:
        """Change how torque reaches the joints."""

    def joint(self, m: Moment) -> None:
        """Add forces on the joints."""

    def read(self, time: np.ndarray, true: np.ndarray, at: np.ndarray) -> np.ndarray | None:
        """A sensor's readings (rows,) at times `at`, from its true values `true` at times `time`; None: unchanged."""
        return None

    def sites(self) -> range | list[int]:
        """Indices it acts at."""
        return range(len(self.motors.gain)) if self.at < 0 else [self.at]

    def drive_torque(self, m: Moment, joint: int) -> float:
        """Torque of the motors of a joint."""
        return sum(t for t, j in zip(m.torque, self.layout.drives, strict=True) if j == joint)


def bristle(force: float, w: float, level: float, stiffness: float, dt: float) -> float:
    """A bristle's force after a step: dF = s (w - |w| F / g) dt, solved exactly for constant w.

    The Dahl model; with g(w) falling in |w| the LuGre model without micro-damping (Canudas de Wit et al. 1995).

    Args:
        force: F before.
        w: speed.
        level: g, the force in steady sliding.
        stiffness: s.
        dt: the step, s.
    """
    if level <= 1e-12:
        return 0.0
    goal = level if w >= 0.0 else -level
    force = goal + (force - goal) * exp(-stiffness * abs(w) * dt / level)
    return min(max(force, -level), level)


class Queue:
    """A value delayed by a whole number of steps."""

    def __init__(self, delay: float) -> None:
        """Delayed by so many seconds."""
        self.delay, self.values = delay, deque[float]()

    def push(self, value: float, dt: float) -> float:
        """Put one in, get the one out that is due; with dt 0 only look."""
        if dt > 0.0:
            self.values.append(value)
            if len(self.values) > round(self.delay / dt) + 1:
                self.values.popleft()
        return self.values[0] if self.values else value
