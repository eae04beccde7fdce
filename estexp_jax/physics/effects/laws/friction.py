"""Dry friction whose level depends on position or direction, as a friction loss renewed at each step."""

from collections.abc import Mapping
from typing import ClassVar, final

import jax.numpy as jnp
import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.bristles import bristle_friction
from estexp_jax.physics.effects.catalogue.hysteresis import Hysteresis
from estexp_jax.physics.effects.laws.base import (
    INITIAL_PHASES,
    PHASE_BOUNDS,
    SPATIAL_FREQUENCIES,
    Bounds,
    JointLaw,
    JointTrajectory,
    MotionRange,
    amplitude,
    difference_text,
    half_span,
    largest_torque,
    signed_text,
)
from estexp_jax.physics.effects.laws.from_effect import EffectLaw
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_REVERSAL = 0.01
"""Speed below which the direction of motion counts less than fully, rad/s or m/s."""


@final
class LawTwoWayFriction(JointLaw):
    """tau = -T (1 + a sign(w)) sign(w): dry friction whose level depends on the direction."""

    name: ClassVar[str] = "law_two_way_friction"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("T", "N m", signed=False),
        Parameter("a", "", signed=True),
    )
    equation: ClassVar[str] = "tau = -T (1 + a sign(w)) sign(w)"
    resembles: ClassVar[str] = "dry friction that is larger one way than the other"
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return ((-1.0, 1.0),)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(a,) for a in (-0.9, -0.5, 0.5, 0.9)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["T"], f"(1 {signed_text(values['a'], 'sign(w)')}) sign(w)")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(friction=p[0] * (1.0 + p[1] * jnp.tanh(joint.w / _REVERSAL))), state


@final
class LawFrictionWave(JointLaw):
    """tau = -T (1 + a sin(n q + phase)) sign(w): friction that rises and falls with position, as of a bent shaft."""

    name: ClassVar[str] = "law_friction_wave"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("T", "N m", signed=False),
        Parameter("a", ""),
        Parameter("n", "1/rad", neutral=1.0),
        Parameter("phase", "rad", signed=True),
    )
    equation: ClassVar[str] = "tau = -T (1 + a sin(n q + phase)) sign(w)"
    resembles: ClassVar[str] = "dry friction that rises and falls along the way"
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (0.0, 1.0), (0.2, 40.0 * max(np.pi / half_span(robot, joint), 1.0)), PHASE_BOUNDS

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        scale = max(1.0, 1.5 / motion.span)
        return [(0.8, n * scale, phase) for n in SPATIAL_FREQUENCIES for phase in INITIAL_PHASES]

    def formula(self, values: Mapping[str, float]) -> str:
        wave = signed_text(values["a"], f"sin({values['n']:.3g} q {signed_text(values['phase'], '')})")
        return signed_text(-values["T"], f"(1 {wave}) sign(w)")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        T, a, n, phase = p
        return JointForce(friction=T * (1.0 + a * jnp.sin(n * joint.q + phase))), state


@final
class LawBristles(EffectLaw, effect=Hysteresis):
    """dF/dq = (T sign(w) - F) / x, tau = -F: dry friction that builds up over a displacement x, like bristles.

    Source: Dahl, A solid friction model, Aerospace Corporation TOR-0158 (1968).
    """

    name: ClassVar[str] = "law_bristles"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("T", "N m", signed=False),
        Parameter("x", "rad", neutral=0.1),
    )
    equation: ClassVar[str] = "tau = -F, dF/dq = (T sign(w) - F) / x"
    resembles: ClassVar[str] = "dry friction that builds up over a short way"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        half = half_span(robot, joint)
        return ((0.001 * half, half),)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(share * motion.span,) for share in (0.005, 0.02, 0.06, 0.2)]

    def formula(self, values: Mapping[str, float]) -> str:
        return f"- F with dF/dq = ({values['T']:.3g} sign(w) - F)/{values['x']:.3g}"

    def effect_values(self, values: Mapping[str, float]) -> Mapping[str, float]:
        return {"T": values["T"], "sigma": values["T"] / values["x"]}

    def hidden_along(self, p: tuple[float, ...], trajectory: JointTrajectory) -> tuple[np.ndarray, ...]:
        T, x = p
        moved, force = np.diff(trajectory.q), np.zeros(len(trajectory.q))
        ends, left = T * np.sign(moved), np.exp(-np.abs(moved) / x)
        for i, (end, share) in enumerate(zip(ends.tolist(), left.tolist(), strict=True)):
            force[i + 1] = end + (force[i] - end) * share
        return force, trajectory.q

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The effect takes the stiffness T / x, and dividing by it would round x: only the friction itself is shared.
        return bristle_friction(p[0], p[1], joint, state)


@final
class LawTightSpot(JointLaw):
    """tau = -T exp(-((q - q0) / s)^2) sign(w): dry friction at one place."""

    name: ClassVar[str] = "law_tight_spot"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        amplitude("T", "N m", signed=False),
        Parameter("q0", "rad", signed=True),
        Parameter("s", "rad", neutral=0.1),
    )
    equation: ClassVar[str] = "tau = -T exp(-((q - q0) / s)^2) sign(w)"
    resembles: ClassVar[str] = "dry friction at one position"
    arms: ClassVar[tuple[str, ...]] = ("dof_frictionloss",)

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        half = half_span(robot, joint)
        return scales.joint_span(robot, joint), (0.005 * half, half)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(q, share * motion.span) for q in motion.positions(9) for share in (0.06, 0.15, 0.4)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["T"], f"exp(-({difference_text('q', values['q0'])}/{values['s']:.3g})^2) sign(w)")

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return JointForce(friction=p[0] * jnp.exp(-jnp.square((joint.q - p[1]) / p[2]))), state
