"""Forces that depend on time or on the earlier motion of a joint: terms with hidden variables."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.laws.base import (
    PHASE_BOUNDS,
    Bounds,
    JointLaw,
    JointTrajectory,
    MotionRange,
    amplitude,
    first_order_lag,
    half_span,
    largest_torque,
    signed_text,
)
from estexp_jax.physics.model.robot import Robot

_FREQUENCIES = (0.15, 8.0)
"""Bounds of the frequency of a periodic force, Hz."""


@final
class LawRhythm(JointLaw):
    """tau = A sin(2 pi f t + phase), t the time since the recording began: a periodic disturbance from outside."""

    name: ClassVar[str] = "law_rhythm"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("A", "N m"),
        Parameter("f", "Hz", neutral=1.0),
        Parameter("phase", "rad", signed=True),
    )
    equation: ClassVar[str] = "tau = A sin(2 pi f t + phase), t the time since the recording began"
    resembles: ClassVar[str] = "a push that comes and goes with time"
    symbols: ClassVar[str] = "t the time since the recording began"
    n_states: ClassVar[int] = 1

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return _FREQUENCIES, PHASE_BOUNDS

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        frequencies = np.arange(_FREQUENCIES[0], _FREQUENCIES[1], 0.2 / motion.duration).tolist()
        return [(f, phase) for f in frequencies for phase in (-np.pi / 4, 0.0, np.pi / 4, np.pi / 2)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(values["A"], f"sin({2.0 * np.pi * values['f']:.4g} t {signed_text(values['phase'], '')})")

    def hidden_along(self, p: tuple[float, ...], trajectory: JointTrajectory) -> tuple[np.ndarray, ...]:
        return (trajectory.time,)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        A, f, phase = p
        (t,) = state
        return JointForce(force=A * jnp.sin(2.0 * np.pi * f * t + phase)), (t + joint.dt,)


@final
class LawCreep(JointLaw):
    """dF/dt = k w - F / T, tau = -F: a spring and a damper in series, as rubber and belts creep.

    Source: Maxwell's model: Findley, Lai and Onaran, Creep and Relaxation of Nonlinear Viscoelastic Materials (1976).
    """

    name: ClassVar[str] = "law_creep"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("k", "N m/rad"), Parameter("T", "s", neutral=1.0))
    equation: ClassVar[str] = "tau = -F, dF/dt = k w - F / T"
    resembles: ClassVar[str] = "a spring that creeps"
    n_states: ClassVar[int] = 1

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint) / (0.1 * half_span(robot, joint))

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return ((0.02, 20.0),)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(T,) for T in (0.05, 0.15, 0.5, 1.5, 5.0)]

    def formula(self, values: Mapping[str, float]) -> str:
        return f"- F with dF/dt = {values['k']:.3g} w - F/{values['T']:.3g}"

    def hidden_along(self, p: tuple[float, ...], trajectory: JointTrajectory) -> tuple[np.ndarray, ...]:
        k, T = p
        return (first_order_lag(k * T * trajectory.w, trajectory.time, T),)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        k, T = p
        (force,) = state
        left = jnp.exp(-joint.dt / T)
        after = force * left + k * T * (1.0 - left) * joint.w
        return JointForce(force=-after), (after,)


@final
class LawThinning(JointLaw):
    """tau = -c w / (1 + a H), dH/dt = (w^2 - H) / T: a damping that falls as motion warms it, like that of grease.

    Source: Carvalho Bittencourt and Axelsson, IEEE/ASME Transactions on Mechatronics 19 (2014).
    """

    name: ClassVar[str] = "law_thinning"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("c", "N m s/rad", signed=False),
        Parameter("a", "s2/rad2"),
        Parameter("T", "s", neutral=1.0),
    )
    equation: ClassVar[str] = "tau = -c w / (1 + a H), dH/dt = (w^2 - H) / T"
    resembles: ClassVar[str] = "a damper that thins as it warms"
    n_states: ClassVar[int] = 1

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (0.0, 1e3), (0.05, 20.0)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(share / motion.speed**2, T) for share in (1.0, 4.0, 16.0) for T in (0.3, 1.0, 3.0)]

    def formula(self, values: Mapping[str, float]) -> str:
        thinner = f"(1 + {values['a']:.3g} H)"
        return f"{signed_text(-values['c'], f'w / {thinner}')} with dH/dt = (w^2 - H)/{values['T']:.3g}"

    def hidden_along(self, p: tuple[float, ...], trajectory: JointTrajectory) -> tuple[np.ndarray, ...]:
        return (first_order_lag(trajectory.w**2, trajectory.time, p[2]),)

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        c, a, T = p
        (heat,) = state
        power = jnp.square(joint.w)
        return JointForce(damping=c / (1.0 + a * heat)), (power + (heat - power) * jnp.exp(-joint.dt / T),)
