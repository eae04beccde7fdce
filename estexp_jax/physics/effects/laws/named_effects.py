"""Terms that repeat a named effect of the catalogue, so that they count only where that effect is left out.

What such a term does is the effect's; stated here are its amplitude, its shapes and its words.
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
    PHASES,
    ROUND,
    WAVES,
    Bounds,
    Reach,
    Shapeless,
    amplitude,
    away,
    half_span,
    signed,
    torque,
)
from estexp_jax.physics.effects.laws.coupling import OTHER_JOINT, Coupling, other_joint
from estexp_jax.physics.effects.laws.from_effect import EffectLaw
from estexp_jax.physics.effects.laws.motor_base import MOTOR
from estexp_jax.physics.model import scales
from estexp_jax.physics.model.robot import Robot

_DENSEST = 60.0
"""Largest spatial frequency, 1/rad or 1/m."""
_FREQUENCIES = 20_000
"""Of so many at most a look is taken: a joint that ran away does not ask for more memory than there is."""


@final
class LawDamping(Shapeless, EffectLaw, effect=ViscousFriction):
    """tau = -c w."""

    name: ClassVar[str] = "law_damping"
    adds_to: ClassVar[str] = "damping"
    resembles: ClassVar[str] = "a resistance in proportion to speed"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["c"], "w")


@final
class LawDrag(Shapeless, EffectLaw, effect=QuadraticDrag):
    """tau = -c |w| w."""

    name: ClassVar[str] = "law_drag"
    resembles: ClassVar[str] = "a resistance that grows with the square of speed, as fluid drag does"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["c"], "|w| w")


@final
class LawDryFriction(Shapeless, EffectLaw, effect=CoulombFriction):
    """tau = -T sign(w)."""

    name: ClassVar[str] = "law_dry_friction"
    adds_to: ClassVar[str] = "friction"
    resembles: ClassVar[str] = "a resistance that is the same at all speeds"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["T"], "sign(w)")


@final
class LawInertia(Shapeless, EffectLaw, effect=Armature):
    """tau = -I dw/dt."""

    name: ClassVar[str] = "law_inertia"
    adds_to: ClassVar[str] = "inertia"
    resembles: ClassVar[str] = "a resistance to changes of speed, as of an inertia"

    def most(self, robot: Robot, joint: int) -> float:
        return scales.rotor_inertia(robot, joint)

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["I"], "dw/dt")


@final
class LawPush(Shapeless, EffectLaw, effect=TorqueOffset):
    """tau = T."""

    name: ClassVar[str] = "law_push"
    resembles: ClassVar[str] = "a push that is always the same"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["T"], "")


@final
class LawSpring(EffectLaw, effect=JointStiffness):
    """tau = -k (q - q0), of either sign."""

    name: ClassVar[str] = "law_spring"
    parameters: ClassVar[tuple[Parameter, ...]] = tuple(replace(p, signed=True) for p in JointStiffness.parameters)
    resembles: ClassVar[str] = "a spring"

    def most(self, robot: Robot, joint: int) -> float:
        return 10.0 * torque(robot, joint) / half_span(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (scales.joint_span(robot, joint),)

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        return [(q,) for q in (reach.low, *reach.places(3), reach.high)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["k"], away("q", values["q0"]))

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        # The effect merges with the joint's own spring, which a spring of negative stiffness cannot.
        return JointForce(force=-p[0] * (moment.q - p[1])), state


@final
class LawWave(EffectLaw, effect=Cogging):
    """tau = A sin(n q + phase)."""

    name: ClassVar[str] = "law_wave"
    resembles: ClassVar[str] = "a force that comes again and again along the way, as the poles of a motor pass"

    def most(self, robot: Robot, joint: int) -> float:
        return torque(robot, joint)

    def shapes(self, robot: Robot, joint: int) -> Bounds:
        return (0.1, _DENSEST), ROUND

    def tried(self, reach: Reach) -> list[tuple[float, ...]]:
        apart = max(0.5 / reach.span, (_DENSEST - 1.0) / _FREQUENCIES)
        dense = np.arange(1.0, _DENSEST, apart).tolist()
        return [(n, phase) for n, phase in product((*WAVES, *dense), PHASES)]

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["A"], f"sin({values['n']:.4g} q {signed(values['phase'], '')})")


@final
class LawLoadFriction(Shapeless, EffectLaw, effect=LoadDependentFriction):
    """tau = -mu |m| sign(w) of motor torque m: teeth that rub the more, the more they carry."""

    name: ClassVar[str] = "law_load_friction"
    equation: ClassVar[str] = "tau = -mu |m| sign(w), m the motor's torque"
    resembles: ClassVar[str] = "friction in proportion to the motor's torque"
    symbols: ClassVar[str] = MOTOR

    def most(self, robot: Robot, joint: int) -> float:
        return 0.95

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["mu"], "|m| sign(w)")


@final
class LawMotorBrake(Shapeless, EffectLaw, effect=BackEmf):
    """tau = -k w while the motor is on: of all motors of a joint together."""

    name: ClassVar[str] = "law_motor_brake"
    resembles: ClassVar[str] = "a motor that brakes in proportion to speed"

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(-values["k"], "w while the motor is on")


@final
class LawDriven(Coupling, EffectLaw, effect=Crosstalk):
    """tau = g m' of the other joint's motor torque m'."""

    name: ClassVar[str] = "law_driven"
    parameters: ClassVar[tuple[Parameter, ...]] = (amplitude("g", ""), OTHER_JOINT)
    equation: ClassVar[str] = "tau = g m', m' the motor torque of joint `with`"
    resembles: ClassVar[str] = "a joint that another one's motor pulls at"
    symbols: ClassVar[str] = "m the torque of the motor of the joint in brackets"

    def most(self, robot: Robot, joint: int) -> float:
        return 1.0

    def formula(self, values: Mapping[str, float]) -> str:
        return signed(values["g"], f"m{other_joint(values)}")

    def act(self, p: Arrays, moment: JointState, state: Arrays) -> tuple[JointForce, Arrays]:
        return super().act(p[::-1], moment, state)  # of the effect, the joint comes first
