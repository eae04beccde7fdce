"""What recordings show of a robot, as far as a search's first values depend on it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from estexp_jax.physics.model.robot import Robot


@final
@dataclass(frozen=True, eq=False)
class Observed:
    """What training recordings show.

    Attributes:
        low: (nq,) least position of each joint.
        high: (nq,) largest position of each joint.
        reading: (nsensordata,) median readings, NaN where there is none.
    """

    low: np.ndarray
    high: np.ndarray
    reading: np.ndarray

    def joint_range(self, robot: Robot, joint: str) -> tuple[float, float]:
        """Least and largest position of a hinge or slide joint, rad or m."""
        place = int(robot.model.jnt_qposadr[robot.index("joint", joint)])
        return float(self.low[place]), float(self.high[place])

    def median_reading(self, robot: Robot, sensor: str) -> float:
        """Median of a sensor's first value, in its unit; NaN where there is none."""
        return float(self.reading[int(robot.model.sensor_adr[robot.index("sensor", sensor)])])
