"""What others published or weighed of ten real machines, one value a row; sources in each data folder's ABOUT.md."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

VISCOUS = ("viscous_friction.c", "back_emf.k", "servo_damping.k")
DRY = ("coulomb_friction.T", "stribeck_friction.T")


@final
@dataclass(frozen=True)
class PublishedValue:
    """A value of a machine.

    Attributes:
        element: joint, actuator or body at which it is.
        kinds: effects and their parameters that say it, as `effect.parameter`.
        value: as published or weighed, in the unit of SPEC.
        regression: what a regression of the logged torque gives, where it was made.
    """

    element: str
    kinds: Sequence[str]
    value: float
    regression: float | None = None


@final
@dataclass(frozen=True)
class Machine:
    """A machine and what is known of it.

    Attributes:
        name: folder of its recordings.
        values: what is published.
        by_hand: error of plain MuJoCo with the published values on the test recordings, in windows of 2 s.
        named: further effects that a good answer may name, as `effect@element`; their size is not known.
        own: whether the values are no publication's but a fit by hand of the same recordings.
    """

    name: str
    values: Sequence[PublishedValue]
    by_hand: float | None = None
    named: Sequence[str] = ()
    own: bool = False


def _each(names: Sequence[str], kinds: Sequence[str], values: Sequence[float], also: Sequence[float] = ()) -> list:
    second = also or [None] * len(values)
    return [PublishedValue(n, kinds, v, r) for n, v, r in zip(names, values, second, strict=True)]


_KR300 = [f"a{i}" for i in range(1, 7)]
_TX40 = [f"joint_{i}" for i in range(1, 7)]
_GO2 = ["FL_hip", "FL_thigh", "FL_calf"]

MACHINES = {
    m.name: m
    for m in (
        Machine(
            "emps",
            [
                PublishedValue("axis", VISCOUS, 203.5034, 204.7),
                PublishedValue("axis", DRY, 20.3935, 20.28),
                PublishedValue("axis", ("torque_offset.T",), 3.1648, 3.17),
            ],
            0.018,
        ),
        Machine(
            "kr300",
            [
                *_each(_KR300, VISCOUS, (1940, 1730, 1562, 280, 468, 384), (1994, 1919, 1256, 258, 580, 376)),
                *_each(_KR300, DRY, (350, 538, 377, 94, 125, 88), (353, 520, 529, 126, 118, 100)),
                PublishedValue("a2", ("joint_stiffness.k",), 6840.0),
            ],
            0.34,
            [f"torque_offset@{name}" for name in _KR300],
        ),
        Machine(
            "tx40",
            [
                *_each(_TX40, VISCOUS, (8.05, 5.53, 1.97, 1.11, 1.86, 0.65), (8.06, 5.59, 2.03, 1.11, 1.26, 0.58)),
                *_each(_TX40, DRY, (7.14, 8.26, 6.34, 2.48, 3.03, 2.0), (7.07, 8.06, 6.17, 2.48, 3.00, 2.61)),
            ],
            0.28,
            [f"torque_offset@{name}" for name in _TX40],
        ),
        Machine(
            "hls_angle",
            [
                PublishedValue("shaft", VISCOUS, 0.057),
                PublishedValue("shaft", (*DRY, "load_dependent_friction.T"), 0.069),
                PublishedValue("shaft", ("armature.I", "joint_compliance.I"), 9.3e-4),
            ],
            0.0111,
            ["load_dependent_friction@shaft"],
            own=True,
        ),
        Machine(
            "go2_leg",
            [
                *_each(_GO2, VISCOUS, (0.27, 0.16, 0.30)),
                *_each(_GO2[2:], DRY, (0.62,)),
                *_each(_GO2, ("armature.I", "joint_compliance.I"), (0.003, 0.004, 0.014)),
                PublishedValue("", ("gravity_tilt.angle",), 0.11),
            ],
            0.029,
            ["coulomb_friction@FL_hip", "coulomb_friction@FL_thigh"],
            own=True,
        ),
        Machine(
            "simple_pendulum",
            [
                PublishedValue("motor", ("motor_weakness.loss", "body_mass.dm"), 0.18),
                PublishedValue("pivot", DRY, 0.14, 0.17),
                PublishedValue("pivot", ("armature.I",), 0.00219),
            ],
            0.163,
            own=True,
        ),
        Machine("pend2_passive", [PublishedValue("joint1", VISCOUS, 2.37143e-4)], 0.0083, ["coulomb_friction@joint1"]),
        Machine(
            "double_pendulum",
            [
                *_each(["shoulder", "elbow"], DRY, (0.25, 0.19)),
                *_each(["shoulder", "elbow"], ("armature.I",), (0.00226, 0.00226)),
            ],
            0.174,
            ["viscous_friction@shoulder", "viscous_friction@elbow"],
        ),
        Machine(
            "xl330",
            [],
            None,
            [
                f"{e}@shaft"
                for e in ("coulomb_friction", "viscous_friction", "stribeck_friction", "load_dependent_friction")
            ],
        ),
        Machine("so101", []),
    )
}
"""All machines by name."""
