"""What laws of motors share."""

from typing import ClassVar

import numpy as np

from estexp_jax.physics.effects.base import Parameter
from estexp_jax.physics.effects.laws.base import Bounds, JointLaw, Reach, amplitude, torque
from estexp_jax.physics.model.robot import Robot

MOTOR = "m the motor's torque"
"""A joint without a motor has none, so that these laws do nothing there."""


class Threshold(JointLaw):
    """A share of the motor's torque that is lost, and the torque where that begins or ends."""

    symbols: ClassVar[str] = MOTOR
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("a", "", signed=False),
        Parameter("m_0", "N m", neutral=1.0),
    )

    def most(self, robot: Robot, joint: int) -> float:
        return 1.0

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return ((0.001 * torque(robot, joint), 2.0 * torque(robot, joint)),)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(share * reach.motor,) for share in (0.05, 0.15, 0.3, 0.5, 0.75)] if reach.motor > 0.0 else []


class Remembering(JointLaw):
    """A share of the motor's torque by a variable that follows it, or its square, with the time constant T."""

    symbols: ClassVar[str] = MOTOR
    n_states: ClassVar[int] = 1

    def most(self, robot: Robot, joint: int) -> float:
        return 1.0

    @staticmethod
    def constants(low: float, high: float) -> list[float]:
        """Time constants to try, s."""
        return np.geomspace(2.0 * low, 0.3 * high, 5).tolist()
