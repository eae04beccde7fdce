"""What an MJCF position servo or motor does, written out: torque from command, position and speed.

servo: tau = clip(kp (u - q) - kv w, low, high)        motor: tau = clip(g u, low, high)
"""

from __future__ import annotations

from dataclasses import dataclass

import mujoco
import numpy as np

from experiments.benchmark.generator.robots import Layout


@dataclass(frozen=True)
class Motors:
    """The drives of a robot.

    Attributes:
        gain, stiffness, damping: g or kp; kp, or 0 for a motor; kv.
        low, high: limits of the torque.
        least, most: limits of the command.
        drives: index of the scalar joint of each.
    """

    gain: tuple[float, ...]
    stiffness: tuple[float, ...]
    damping: tuple[float, ...]
    low: tuple[float, ...]
    high: tuple[float, ...]
    least: tuple[float, ...]
    most: tuple[float, ...]
    drives: tuple[int, ...]

    @staticmethod
    def of(model: mujoco.MjModel, layout: Layout) -> Motors:
        """Read the drives of a compiled model."""
        gain, bias = model.actuator_gainprm[:, 0], model.actuator_biasprm
        forced, commanded = model.actuator_forcelimited.astype(bool), model.actuator_ctrllimited.astype(bool)
        force = np.where(forced[:, None], model.actuator_forcerange, [-np.inf, np.inf])
        ctrl = np.where(commanded[:, None], model.actuator_ctrlrange, [-np.inf, np.inf])
        columns = (gain, -bias[:, 1], -bias[:, 2], force[:, 0], force[:, 1], ctrl[:, 0], ctrl[:, 1])
        return Motors(*(tuple(map(float, c)) for c in columns), drives=layout.drives)

    def clipped(self, command: list[float]) -> list[float]:
        """Commands (actuators) within their range."""
        return [min(max(u, a), b) for u, a, b in zip(command, self.least, self.most, strict=True)]

    def error(self, a: int, u: float, q: list[float]) -> float:
        """What a motor acts on: the command, less the position where it is a servo."""
        return u - q[self.drives[a]] if self.stiffness[a] else u

    def torque(self, a: int, error: float, w: list[float]) -> float:
        """Torque of a motor at its joint, from what it acts on and the joint's speed."""
        raw = self.gain[a] * error - self.damping[a] * w[self.drives[a]]
        return min(max(raw, self.low[a]), self.high[a])
