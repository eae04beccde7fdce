"""The paper's unanticipated situations, at places drawn with a seed.

Source: Bongard and Lipson 2004, Table 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import mujoco
import numpy as np

from estexp_jax.errors import InputError
from estexp_jax.physics.effects.catalogue.body_mass import BodyMass
from estexp_jax.physics.effects.catalogue.gravity_tilt import GravityTilt
from estexp_jax.physics.effects.catalogue.joint_jam import JointJam
from estexp_jax.physics.effects.catalogue.motor_weakness import MotorWeakness
from estexp_jax.physics.effects.catalogue.neuron_fault import NeuronFault
from estexp_jax.physics.effects.catalogue.part_lost import PartLost
from estexp_jax.physics.effects.catalogue.sensor_gain import SensorGain
from estexp_jax.physics.effects.catalogue.tied_outputs import TiedOutputs
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.damage import Damage
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.estimation.damage_sites import DamageSite, change_of, damage_sites

TABLE: dict[int, str] = {
    1: "one motor weakens by 50 %",
    2: "the mass of one body doubles",
    3: "an entire leg breaks off",
    4: "an entire leg breaks off, and a sensor fails by 50 %",
    5: "an angle sensor fails by 50 %",
    6: "a joint jams by 50 %",
    7: "an entire leg breaks off, and a joint jams by 50 %",
    8: "an entire leg breaks off, a joint jams by 50 %, and a sensor fails by 50 %",
    9: "nothing breaks",
    10: "the robot stands on a slope of 30 degrees, sideways to its way",
    11: "a hidden neuron fails by 50 %",
    12: "two motor neurons give the same value",
    13: "the mass of one body halves",
}
"""The thirteen situations. Where the paper says "increases by 200 %", the mass doubles: the genome's maximum."""

_TAG = 13
_ANGLE = int(mujoco.mjtSensor.mjSENS_JOINTPOS)


def situation(number: int, robot: Robot, seed: int) -> tuple[Change, ...]:
    """The damage of one situation.

    Args:
        number: 1 to 13.
        robot: the nominal robot; places are drawn among its own.
        seed: of the draw.

    Raises:
        InputError: the situation does not exist, or the robot has no element for it.
    """
    if number not in TABLE:
        raise InputError(f"there is no situation {number}", right="1 to 13, as in the paper's Table 1")
    draw = _Draw(robot, number, np.random.default_rng([seed, _TAG, number]))
    return _RECIPES[number](draw)


class _Draw:
    """Draws damage sites on one robot for one situation."""

    def __init__(self, robot: Robot, number: int, random: np.random.Generator) -> None:
        self.robot, self.number, self.random = robot, number, random

    def one(self, choices: Sequence[str], what: str) -> str:
        """A name drawn among the choices.

        Raises:
            InputError: there is no choice; `what` says of what.
        """
        if not choices:
            right = f"choose another situation or --damage: {TABLE[self.number]}"
            raise InputError(
                f"situation {self.number} needs {what}, and the robot has none", where=self.robot.source, right=right
            )
        return str(choices[int(self.random.integers(len(choices)))])

    def edit(self, kind: type[Damage], amount: float, what: str, spared: frozenset[int] = frozenset()) -> Change:
        """One of the paper's modifications at a site that is not on a spared body."""
        choices = [p for p in damage_sites(self.robot, kind.name) if not self._body(p) & spared]
        chosen = self.one([p.name or "" for p in choices], what)
        return change_of(self.robot, DamageSite(kind.name, chosen), amount)

    def leg(self) -> Change:
        """Loss of an entire leg: a part joined to the root by a hinge or slide."""
        robot = self.robot
        lost = [robot.index("body", name) for name in effect(PartLost.name).sites(robot)]
        legs = [b for b in lost if int(robot.model.body_parentid[b]) not in lost]
        names = [robot.names("body")[b] for b in legs]
        return change_of(robot, DamageSite(PartLost.name, self.one(names, "a leg")), 1.0)

    def angle(self) -> Change:
        """An angle sensor that reads half the angle."""
        robot = self.robot
        names = interface_of(robot).names
        angles = [n for n in names if int(robot.model.sensor_type[robot.index("sensor", n)]) == _ANGLE]
        return change_of(robot, DamageSite(SensorGain.name, self.one(angles, "an angle sensor")), 0.5)

    def with_leg(self, *others: tuple[type[Damage], str]) -> tuple[Change, ...]:
        """Loss of a leg, and other failures by 50 % that are not on it."""
        leg = self.leg()
        spared = frozenset(self.robot.subtree(self.robot.index("body", leg.name or "")))
        return (leg, *(self.edit(kind, 0.5, what, spared) for kind, what in others))

    def neuron(self) -> Change:
        """A hidden neuron with half its output."""
        neurons = effect(NeuronFault.name).sites(self.robot)
        return change_of(self.robot, DamageSite(NeuronFault.name, self.one(neurons, "a neuron")), 0.5)

    def tie(self) -> Change:
        """A motor that repeats another's command."""
        motors = self.robot.names("actuator")
        first = self.one(motors, "a motor")
        second = self.one([m for m in motors if m != first], "a second motor")
        return change_of(self.robot, DamageSite(TiedOutputs.name, first, 1 + motors.index(second)), 1.0)

    def _body(self, place: DamageSite) -> frozenset[int]:
        robot, name = self.robot, place.name or ""
        match effect(place.effect).kind:
            case "joint":
                return frozenset({int(robot.model.jnt_bodyid[robot.index("joint", name)])})
            case "sensor":
                body = robot.body_of_sensor(robot.index("sensor", name))
                return frozenset() if body is None else frozenset({body})
            case _:
                return frozenset()


_JAM, _SENSOR = (JointJam, "a joint"), (SensorGain, "a sensor")


def _slope(draw: _Draw) -> tuple[Change, ...]:
    return (change_of(draw.robot, DamageSite(GravityTilt.name, None), 1.0),)


_RECIPES: dict[int, Callable[[_Draw], tuple[Change, ...]]] = {
    1: lambda draw: (draw.edit(MotorWeakness, 0.5, "a motor"),),
    2: lambda draw: (draw.edit(BodyMass, 1.0, "a body"),),
    3: lambda draw: draw.with_leg(),
    4: lambda draw: draw.with_leg(_SENSOR),
    5: lambda draw: (draw.angle(),),
    6: lambda draw: (draw.edit(JointJam, 0.5, "a joint"),),
    7: lambda draw: draw.with_leg(_JAM),
    8: lambda draw: draw.with_leg(_JAM, _SENSOR),
    9: lambda draw: (),
    10: _slope,
    11: lambda draw: (draw.neuron(),),
    12: lambda draw: (draw.tie(),),
    13: lambda draw: (draw.edit(BodyMass, -0.5, "a body"),),
}
