"""Which effects are planted, and at which robots: each of SPEC's, on two."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True)
class Plan:
    """A case.

    Attributes:
        effect: what is planted, as `estexp record` takes it.
        robot: a key of `MODELS`.
        has_element: whether MuJoCo is known to have an element for it on this robot.
    """

    effect: str
    robot: str
    has_element: bool = True

    @property
    def name(self) -> str:
        """Of its effect."""
        return self.effect.partition("@")[0].partition(" ")[0]


_SEEN_BY_SERVO = "servo"
_ANYWHERE = (
    "command_delay@lower_motor delay=0.03",
    "stribeck_friction@elbow T=0.1 S=0.15 w_s=0.3",
    "backlash@elbow half_gap=0.05",
    "coulomb_friction@elbow T=0.15",
    "actuator_lag@upper_motor tau=0.04",
    "hysteresis@elbow T=0.15 sigma=3",
    "joint_compliance@elbow k=12 d=0.05 I=0.004",
    "cogging@elbow A=0.15 n=7 phase=0.5",
    "viscous_friction@elbow c=0.1",
    "quadratic_drag@elbow c=0.05",
    "joint_stiffness@shoulder k=1 q0=0.2",
    "armature@elbow I=0.01",
    "joint_limit@elbow low=-0.25 high=0.3",
    "joint_jam@elbow f=0.9",
    "torque_offset@shoulder T=0.3",
    "motor_weakness@lower_motor loss=0.4",
    "torque_saturation@upper_motor limit=0.8",
    "back_emf@lower_motor k=0.1",
    "sensor_delay@lower_angle delay=0.03",
    "body_mass@lower dm=0.2",
    "com_shift@lower x=0.03 y=0 z=-0.05",
    "joint_offset@elbow offset=0.1",
    "part_lost@lower lost=1",
    "gravity_tilt angle=0.2 axis=1",
    "external_force@lower x=0.8 y=0 z=0 k=0",
    "gravity_compensation@* share=0.6",
)
_NEVER_NATIVE = (
    "supply_sag R=0.1",
    "motor_fade@upper_motor loss=0.7 tau=1.5",
    "load_dependent_friction@shoulder mu=0.3",
    "sensor_gain@lower_angle gain=1.1",
    "sensor_bias@lower_angle bias=0.1",
    "sensor_stuck@lower_angle value=0.2",
)
_OF_TORQUES = ("crosstalk@elbow from=shoulder g=0.2", "tied_outputs@lower_motor with=upper_motor")
"""MuJoCo has elements for these where the motors' own loops see nothing."""


def planned() -> dict[str, Plan]:
    """The cases by their names, those first that say most."""
    found = [Plan(effect, robot) for effect in _ANYWHERE for robot in ("servo", "torque")]
    found += [Plan(effect, robot, robot == "torque") for effect in _OF_TORQUES for robot in ("servo", "torque")]
    found += [Plan("ground_friction mu=0.8", robot) for robot in ("servo_block", "torque_block")]
    found += [Plan("mount_compliance@post k=60 d=3", robot) for robot in ("servo_gyro", "torque_gyro")]
    found += [Plan(effect, robot, False) for effect in _NEVER_NATIVE for robot in ("servo", "torque")]
    found += [Plan("dead_band@lower_motor half_width=0.1", "servo", False)]
    found += [Plan("dead_band@lower_motor half_width=0.2", "torque", False)]
    found += [Plan("command_limit@upper_motor v=1.2 a=8", "servo", False)]
    found += [Plan("command_limit@push v=0.25 a=2", "servo_block", False)]
    return {f"{plan.name}.{plan.robot}": plan for plan in found}
