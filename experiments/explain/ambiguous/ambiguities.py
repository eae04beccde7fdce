"""Two or three effects that a first motion cannot distinguish, on robots where another motion can."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import final

import numpy as np

from experiments.explain.ambiguous.motions import Motion, either_way, one_way, slow
from experiments.explain.ambiguous.robots import Number, hanging, level, motor, standing, turning


@final
@dataclass(frozen=True)
class Ambiguity:
    """An ambiguity.

    Attributes:
        name: in words.
        robot: its MJCF, of what becomes of numbers.
        effects: each with its parameters at a strength in 0..1, as `estexp record --effect` takes it.
        motion: the first one, under which they say the same.
        equals: names that say the same as one of them on this robot, whatever its commands.
        noise: deviation of the noise on angles, rad: so much that what the first motion shows of the difference drowns.
        rest: for which the robot stands before a recording begins, s.
    """

    name: str
    robot: Callable[[Number], str]
    effects: tuple[Callable[[float], str], ...]
    motion: Motion
    equals: Mapping[str, str] = field(default_factory=dict)
    noise: float = 8e-3
    rest: float = 0.0

    @property
    def names(self) -> tuple[str, ...]:
        """Of the effects."""
        return tuple(effect(0.5).split()[0].partition("@")[0] for effect in self.effects)

    def said(self, effects: Iterable[str]) -> tuple[str, ...]:
        """Those of the ambiguity that some effects are, or say."""
        meant = {self.equals.get(name, name) for name in effects}
        return tuple(name for name in self.names if name in meant)


AMBIGUITIES = (
    Ambiguity(
        "payload or weak motor",
        motor,
        (
            lambda s: f"body_mass@arm dm={0.3 * (1.0 + 0.4 * s):.6g}",
            lambda s: f"motor_weakness@motor loss={0.52 + 0.08 * s:.6g}",
        ),
        slow(0.07),
    ),
    Ambiguity(
        "delay or viscous friction",
        level,
        (
            lambda s: f"command_delay@servo delay={0.06 + 0.04 * s:.6g}",
            lambda s: f"viscous_friction@hinge c={0.24 + 0.16 * s:.6g}",
        ),
        slow(0.5),
        {"sensor_delay": "command_delay", "back_emf": "viscous_friction"},
    ),
    Ambiguity(
        "backlash, delay or stiction",
        level,
        (
            lambda s: f"backlash@hinge half_gap={0.014 + 0.008 * s:.6g}",
            lambda s: f"command_delay@servo delay={0.08 + 0.04 * s:.6g}",
            lambda s: f"coulomb_friction@hinge T={0.056 + 0.032 * s:.6g}",
        ),
        one_way(0.18),
        {"sensor_delay": "command_delay"},
    ),
    Ambiguity(
        "sensor gain or payload",
        hanging,
        (
            lambda s: f"sensor_gain@angle gain={0.8 - 0.06 * s:.6g}",
            lambda s: f"body_mass@arm dm={0.3 * (2.2 + 0.8 * s):.6g}",
        ),
        slow(0.3),
    ),
    Ambiguity(
        "joint offset or sensor bias",
        hanging,
        (
            lambda s: f"joint_offset@hinge offset={0.3 + 0.1 * s:.6g}",
            lambda s: f"sensor_bias@angle bias={-0.03 - 0.01 * s:.6g}",
        ),
        slow(0.25),
        {"gravity_tilt": "joint_offset"},
    ),
    Ambiguity(
        "saturation or weak motor",
        motor,
        (
            lambda s: f"torque_saturation@motor limit={0.3 * (0.48 - 0.1 * s):.6g}",
            lambda s: f"motor_weakness@motor loss={0.4 + 0.15 * s:.6g}",
        ),
        either_way(0.3),
        noise=2e-3,
    ),
    Ambiguity(
        "tilt or centre of mass",
        turning,
        (
            lambda s: f"gravity_tilt angle={0.2 + 0.1 * s:.6g} axis={np.pi / 2:.9g}",
            lambda s: f"com_shift@arm x={-0.03 - 0.015 * s:.6g}",
        ),
        slow(0.3, joints=2, at=1),
        {"joint_offset": "com_shift"},
        noise=2e-3,
    ),
    Ambiguity(
        "quadruped: payload or weak motors",
        standing,
        (
            lambda s: f"body_mass@torso dm={2.0 + 0.5 * s:.6g}",
            lambda s: f"motor_weakness@* loss={0.38 + 0.05 * s:.6g}",
        ),
        slow(0.2, joints=8),
        rest=2.0,
    ),
)
