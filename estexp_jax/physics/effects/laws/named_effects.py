"""Terms that repeat a named effect of the catalogue: they count only where that effect may not be claimed.

Their physics is the effect's. Stated here are the bounds, the initial guesses and the words.
"""

from collections.abc import Mapping
from dataclasses import replace
from itertools import product
from typing import ClassVar, final

import numpy as np

from estexp_jax.physics.effects.base import Arrays, JointForce, JointState, Parameter
from estexp_jax.physics.effects.catalogue.armature import Armature
from estexp_jax.physics.effects.catalogue.back_emf import BackEmf
from estexp_jax.physics.effects.catalogue.cogging import Cogging
from estexp_jax.physics.effects.catalogue.coulomb_friction import CoulombFriction
from estexp_jax.physics.effects.catalogue.crosstalk import Crosstalk
from estexp_jax.physics.effects.catalogue.joint_stiffness import JointStiffness
from estexp_jax.physics.effects.catalogue.load_dependent_friction import LoadDependentFriction
from estexp_jax.physics.effects.catalogue.quadratic_drag import QuadraticDrag
from estexp_jax.physics.effects.catalogue.torque_offset import TorqueOffset
from estexp_jax.physics.effects.catalogue.viscous_friction import ViscousFriction
from estexp_jax.physics.effects.laws.base import (
    INITIAL_PHASES,
    PHASE_BOUNDS,
    SPATIAL_FREQUENCIES,
    AmplitudeOnly,
    Bounds,
    MotionRange,
    amplitude,
    difference_text,
    half_span,
    largest_torque,
    signed_text,
)
from estexp_jax.physics.effects.laws.coupling import WITH_JOINT, CouplingLaw, other_joint
from estexp_jax.physics.effects.laws.from_effect import EffectLaw
from estexp_jax.physics.effects.laws.motor_base import MOTOR_TORQUE
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_HIGHEST_FREQUENCY = 60.0
"""Bound of a spatial frequency, 1/rad or 1/m."""
_MOST_FREQUENCIES = 20_000
"""Largest number of initial guesses of it: a joint that ran away must not exhaust the memory."""


@final
class LawDamping(AmplitudeOnly, EffectLaw, effect=ViscousFriction):
    """tau = -c w."""

    name: ClassVar[str] = "law_damping"
    adds_to: ClassVar[str] = "damping"
    resembles: ClassVar[str] = "a resistance in proportion to speed"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["c"], "w")


@final
class LawDrag(AmplitudeOnly, EffectLaw, effect=QuadraticDrag):
    """tau = -c |w| w."""

    name: ClassVar[str] = "law_drag"
    resembles: ClassVar[str] = "a resistance that grows with the square of speed, as fluid drag does"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["c"], "|w| w")


@final
class LawDryFriction(AmplitudeOnly, EffectLaw, effect=CoulombFriction):
    """tau = -T sign(w)."""

    name: ClassVar[str] = "law_dry_friction"
    adds_to: ClassVar[str] = "friction"
    resembles: ClassVar[str] = "a resistance that is the same at all speeds"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["T"], "sign(w)")


@final
class LawInertia(AmplitudeOnly, EffectLaw, effect=Armature):
    """tau = -I dw/dt."""

    name: ClassVar[str] = "law_inertia"
    adds_to: ClassVar[str] = "inertia"
    resembles: ClassVar[str] = "a resistance to changes of speed, as of an inertia"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return scales.rotor_inertia(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["I"], "dw/dt")


@final
class LawPush(AmplitudeOnly, EffectLaw, effect=TorqueOffset):
    """tau = T."""

    name: ClassVar[str] = "law_push"
    resembles: ClassVar[str] = "a push that is always the same"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(values["T"], "")


@final
class LawSpring(EffectLaw, effect=JointStiffness):
    """tau = -k (q - q0), of either sign."""

    name: ClassVar[str] = "law_spring"
    parameters: ClassVar[tuple[Parameter, ...]] = tuple(replace(p, signed=True) for p in JointStiffness.parameters)
    resembles: ClassVar[str] = "a spring"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return 10.0 * largest_torque(robot, joint) / half_span(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (scales.joint_span(robot, joint),)

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        return [(q,) for q in (motion.low, *motion.positions(3), motion.high)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["k"], difference_text("q", values["q0"]))

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The effect merges with the joint's own spring, which a spring of negative stiffness cannot.
        return JointForce(force=-p[0] * (joint.q - p[1])), state


@final
class LawWave(EffectLaw, effect=Cogging):
    """tau = A sin(n q + phase)."""

    name: ClassVar[str] = "law_wave"
    resembles: ClassVar[str] = "a force that comes again and again along the way, as the poles of a motor pass"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return largest_torque(robot, joint)

    def shape_bounds(self, robot: Robot, joint: int) -> Bounds:
        return (0.1, _HIGHEST_FREQUENCY), PHASE_BOUNDS

    def initial_shapes(self, motion: MotionRange) -> list[tuple[float, ...]]:
        spacing = max(0.5 / motion.span, (_HIGHEST_FREQUENCY - 1.0) / _MOST_FREQUENCIES)
        dense = np.arange(1.0, _HIGHEST_FREQUENCY, spacing).tolist()
        return [(n, phase) for n, phase in product((*SPATIAL_FREQUENCIES, *dense), INITIAL_PHASES)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(values["A"], f"sin({values['n']:.4g} q {signed_text(values['phase'], '')})")


@final
class LawLoadFriction(AmplitudeOnly, EffectLaw, effect=LoadDependentFriction):
    """tau = -mu |m| sign(w) of motor torque m: gear friction in proportion to the load."""

    name: ClassVar[str] = "law_load_friction"
    equation: ClassVar[str] = "tau = -mu |m| sign(w), m the motor's torque"
    resembles: ClassVar[str] = "friction in proportion to the motor's torque"
    symbols: ClassVar[str] = MOTOR_TORQUE

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return 0.95

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["mu"], "|m| sign(w)")


@final
class LawMotorBrake(AmplitudeOnly, EffectLaw, effect=BackEmf):
    """tau = -k w while the motor is on: of all motors of a joint together."""

    name: ClassVar[str] = "law_motor_brake"
    resembles: ClassVar[str] = "a motor that brakes in proportion to speed"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(-values["k"], "w while the motor is on")


@final
class LawDriven(CouplingLaw, EffectLaw, effect=Crosstalk):
    """tau = g m' of the other joint's motor torque m'."""

    name: ClassVar[str] = "law_driven"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", ""), WITH_JOINT)
    equation: ClassVar[str] = "tau = g m', m' the motor torque of joint `with`"
    resembles: ClassVar[str] = "a joint that another one's motor pulls at"
    symbols: ClassVar[str] = "m the torque of the motor of the joint in brackets"

    def largest_amplitude(self, robot: Robot, joint: int) -> float:
        return 1.0

    def formula(self, values: Mapping[str, float]) -> str:
        return signed_text(values["g"], f"m{other_joint(values)}")

    def effect_values(self, values: Mapping[str, float]) -> Mapping[str, float]:
        return {"from": values[WITH_JOINT.name], "g": values["g"]}

    def act(self, p: Arrays, joint: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return super().act(p[::-1], joint, state)  # of the effect, the joint comes first
