"""The catalogue: every effect by name, those of the user's own, and the paper's six."""

from __future__ import annotations

from collections.abc import Iterable

from estexp_jax.errors import InputError, known
from estexp_jax.physics.effects.base import Effect
from estexp_jax.physics.effects.catalogue.actuator_lag import ActuatorLag
from estexp_jax.physics.effects.catalogue.armature import Armature
from estexp_jax.physics.effects.catalogue.back_emf import BackEmf
from estexp_jax.physics.effects.catalogue.backlash import Backlash, RotorBacklash
from estexp_jax.physics.effects.catalogue.body_mass import BodyMass
from estexp_jax.physics.effects.catalogue.cogging import Cogging
from estexp_jax.physics.effects.catalogue.com_shift import ComShift
from estexp_jax.physics.effects.catalogue.command_delay import CommandDelay
from estexp_jax.physics.effects.catalogue.coulomb_friction import CoulombFriction
from estexp_jax.physics.effects.catalogue.crosstalk import Crosstalk
from estexp_jax.physics.effects.catalogue.dead_band import DeadBand
from estexp_jax.physics.effects.catalogue.external_force import ExternalForce
from estexp_jax.physics.effects.catalogue.gravity_tilt import GravityTilt
from estexp_jax.physics.effects.catalogue.ground_friction import GroundFriction
from estexp_jax.physics.effects.catalogue.hysteresis import Hysteresis
from estexp_jax.physics.effects.catalogue.joint_compliance import JointCompliance, OuterCompliance
from estexp_jax.physics.effects.catalogue.joint_jam import JointJam
from estexp_jax.physics.effects.catalogue.joint_limit import JointLimit
from estexp_jax.physics.effects.catalogue.joint_offset import JointOffset
from estexp_jax.physics.effects.catalogue.joint_stiffness import JointStiffness
from estexp_jax.physics.effects.catalogue.load_bristles import LoadBristles
from estexp_jax.physics.effects.catalogue.load_dependent_friction import LoadDependentFriction
from estexp_jax.physics.effects.catalogue.motor_fade import MotorFade
from estexp_jax.physics.effects.catalogue.motor_heat import MotorHeat
from estexp_jax.physics.effects.catalogue.motor_weakness import MotorWeakness
from estexp_jax.physics.effects.catalogue.neuron_fault import NeuronFault
from estexp_jax.physics.effects.catalogue.outer_backlash import OuterBacklash
from estexp_jax.physics.effects.catalogue.part_lost import PartLost
from estexp_jax.physics.effects.catalogue.part_stub import PartStub
from estexp_jax.physics.effects.catalogue.quadratic_drag import QuadraticDrag
from estexp_jax.physics.effects.catalogue.rebound_limit import ReboundLimit
from estexp_jax.physics.effects.catalogue.sensor_bias import SensorBias
from estexp_jax.physics.effects.catalogue.sensor_delay import SensorDelay
from estexp_jax.physics.effects.catalogue.sensor_gain import SensorGain
from estexp_jax.physics.effects.catalogue.sensor_stuck import SensorStuck
from estexp_jax.physics.effects.catalogue.servo_damping import ServoDamping
from estexp_jax.physics.effects.catalogue.stribeck_bristles import StribeckBristles
from estexp_jax.physics.effects.catalogue.stribeck_friction import StribeckFriction
from estexp_jax.physics.effects.catalogue.tied_outputs import TiedOutputs
from estexp_jax.physics.effects.catalogue.torque_offset import TorqueOffset
from estexp_jax.physics.effects.catalogue.torque_saturation import TorqueSaturation
from estexp_jax.physics.effects.catalogue.viscous_friction import ViscousFriction
from estexp_jax.physics.effects.laws.base import JointLaw
from estexp_jax.physics.effects.laws.commands import LawDeafMotor, LawLateCommand
from estexp_jax.physics.effects.laws.coupling import (
    LawFling,
    LawSquareFling,
    LawStir,
    LawTie,
    LawTow,
    LawWhirl,
)
from estexp_jax.physics.effects.laws.friction import LawBristles, LawFrictionWave, LawTightSpot, LawTwoWayFriction
from estexp_jax.physics.effects.laws.motors import (
    LawClippedMotor,
    LawSag,
    LawSlowMotor,
    LawSoftMotor,
    LawWarmMotor,
    LawWeakMotor,
)
from estexp_jax.physics.effects.laws.named_effects import (
    LawDamping,
    LawDrag,
    LawDriven,
    LawDryFriction,
    LawInertia,
    LawLoadFriction,
    LawMotorBrake,
    LawPush,
    LawSpring,
    LawWave,
)
from estexp_jax.physics.effects.laws.position import (
    LawBump,
    LawCube,
    LawDetent,
    LawLowerSpring,
    LawSquare,
    LawUpperSpring,
)
from estexp_jax.physics.effects.laws.sensors import LawDrift
from estexp_jax.physics.effects.laws.speed import (
    LawCubicDrag,
    LawFallingFriction,
    LawHump,
    LawOneWayDamping,
    LawPlaceDamping,
    LawSmoothFriction,
)
from estexp_jax.physics.effects.laws.time_dependent import LawCreep, LawRhythm, LawThinning

Catalogue = tuple[Effect, ...]

ALL: Catalogue = (
    ViscousFriction(),
    CoulombFriction(),
    StribeckFriction(),
    LoadDependentFriction(),
    QuadraticDrag(),
    JointStiffness(),
    Cogging(),
    Armature(),
    JointLimit(),
    JointJam(),
    Hysteresis(),
    Crosstalk(),
    TorqueOffset(),
    MotorWeakness(),
    TorqueSaturation(),
    BackEmf(),
    MotorFade(),
    JointCompliance(),
    Backlash(),
    CommandDelay(),
    ActuatorLag(),
    DeadBand(),
    TiedOutputs(),
    SensorGain(),
    SensorBias(),
    SensorDelay(),
    SensorStuck(),
    BodyMass(),
    ComShift(),
    JointOffset(),
    PartLost(),
    GravityTilt(),
    GroundFriction(),
    ExternalForce(),
    NeuronFault(),
)
"""Every effect the program knows. Terms act in this order: what changes a motor's torque, then what passes it on."""

VARIANTS: Catalogue = (
    StribeckBristles(),
    LoadBristles(),
    ServoDamping(),
    PartStub(),
    OuterCompliance(),
    OuterBacklash(),
    RotorBacklash(),
    ReboundLimit(),
    MotorHeat(),
)
"""Other forms of effects of the catalogue, told under its names."""

LAWS: tuple[JointLaw, ...] = (
    LawSquare(),
    LawCube(),
    LawBump(),
    LawDetent(),
    LawUpperSpring(),
    LawLowerSpring(),
    LawOneWayDamping(),
    LawCubicDrag(),
    LawSmoothFriction(),
    LawHump(),
    LawPlaceDamping(),
    LawTwoWayFriction(),
    LawFrictionWave(),
    LawTightSpot(),
    LawTow(),
    LawFling(),
    LawSquareFling(),
    LawStir(),
    LawWhirl(),
    LawTie(),
    LawRhythm(),
    LawCreep(),
    LawThinning(),
    LawSoftMotor(),
    LawSlowMotor(),
    LawDamping(),
    LawDrag(),
    LawDryFriction(),
    LawInertia(),
    LawPush(),
    LawSpring(),
    LawWave(),
    LawFallingFriction(),
    LawLoadFriction(),
    LawWeakMotor(),
    LawMotorBrake(),
    LawClippedMotor(),
    LawDeafMotor(),
    LawWarmMotor(),
    LawLateCommand(),
    LawDriven(),
    LawBristles(),
)
"""Terms of unknown laws: nobody claims one by name; a few of them at one joint are told as its `unknown_law`."""

NAMELESS: Catalogue = (LawSag(), LawDrift())
"""Unknown laws of other elements than joints: each is claimed as an effect is, not put together of terms."""

PAPER = ("part_lost", "body_mass", "motor_weakness", "sensor_gain", "joint_jam", "gravity_tilt")
"""The six edits of the paper's estimation phase, in the order of its genome."""

_OWN: dict[str, Effect] = {}
"""Effects that were registered in this process, by their names."""


def own() -> Catalogue:
    """The effects that were registered beside the catalogue."""
    return tuple(_OWN.values())


def every() -> Catalogue:
    """All effects that have a name, in the order in which terms act."""
    return (*ALL, *VARIANTS, *LAWS, *NAMELESS, *own())


def add(effect: Effect) -> None:
    """Put an effect beside the catalogue, in the place of an earlier one of the user's that has its name.

    Raises:
        InputError: the program has one of that name.
    """
    if effect.name in {e.name for e in (*ALL, *VARIANTS, *LAWS, *NAMELESS)}:
        raise InputError(f"there is an effect '{effect.name}' already", right="call yours otherwise")
    _OWN[effect.name] = effect


def drop(effect: Effect) -> None:
    """Take an effect of the user's own away again, if it is there."""
    for name in [name for name, one in _OWN.items() if one is effect]:
        del _OWN[name]


def effect(name: str) -> Effect:
    """The effect of that name.

    Raises:
        InputError: there is none; the message lists the catalogue.
    """
    for candidate in every():
        if candidate.name == name:
            return candidate
    raise InputError(f"there is no effect '{name}'", right=known(e.name for e in (*ALL, *own())))


def catalogue(names: Iterable[str]) -> Catalogue:
    """The effects of those names, in that order."""
    return tuple(effect(name) for name in names)
