"""Parameters and initial guesses that the terms about motors share."""

from typing import ClassVar

import numpy as np

from estexp_jax.physics.effects.base import Parameter
from estexp_jax.physics.effects.laws.base import Bounds, JointLaw, MotionRange, amplitude, largest_torque
from estexp_jax.physics.model.robot import Robot

MOTOR_TORQUE = "m the motor's torque"
"""Meaning of m in formulas. It is 0 at a joint without a motor, so that these terms do nothing there."""


class MotorThresholdLaw(JointLaw):
    """A share of the motor's torque is lost beyond, or up to, the torque m_0."""

    symbols: ClassVar[str] = MOTOR_TORQUE
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("a", "", signed=False),
        Parameter("m_0", "N m", neutral=1.0),
    )

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return 1.0

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return ((0.001 * largest_torque(robot, joint), 2.0 * largest_torque(robot, joint)),)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        shares = (0.05, 0.15, 0.3, 0.5, 0.75) if motion.motor_torque > 0.0 else ()
        return [(share * motion.motor_torque,) for share in shares]


class LaggedMotorLaw(JointLaw):
    """The motor's torque changes by a variable that lags it, or its square, with the time constant T."""

    symbols: ClassVar[str] = MOTOR_TORQUE
    n_states: ClassVar[int] = 1

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return 1.0

    @staticmethod
    def time_constants(low: float, high: float) -> list[float]:
        """Initial guesses of a time constant within bounds, s."""
        return np.geomspace(2.0 * low, 0.3 * high, 5).tolist()
