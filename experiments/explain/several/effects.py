"""Effects that real arms have and their models lack: how they are drawn, and under which names they count as found."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import final

import numpy as np

from experiments.explain.published.values import DRY
from experiments.explain.several.arms import Arm


@final
@dataclass(frozen=True)
class ArmEffect:
    """An effect at a joint; motors, links and sensors count as their joints'.

    Attributes:
        effect: its name.
        joint: from 0.
        parameters: by name.
    """

    effect: str
    joint: int
    parameters: Mapping[str, float]


Draw = Callable[[Arm, int, float, np.random.Generator], dict[str, float]]
"""(arm, joint, strength, what decides) -> parameters."""
_WEAKEST, _STRONGEST = 0.12, 0.6
_LEAST, _MOST = 3, 8
_KINDS: Mapping[str, tuple[str, str, Draw]] = {
    "viscous_friction": ("joint", "j", lambda a, j, s, r: {"c": s * a.torque[j] / a.speed[j]}),
    "coulomb_friction": ("joint", "j", lambda a, j, s, r: {"T": s * a.torque[j]}),
    "load_dependent_friction": ("joint", "j", lambda a, j, s, r: {"mu": 0.5 * s}),
    "stribeck_friction": (
        "joint",
        "j",
        lambda a, j, s, r: {
            "T": 0.6 * s * a.torque[j],
            "S": 0.6 * s * a.torque[j],
            "w_s": r.uniform(0.15, 0.5) * a.speed[j],
        },
    ),
    "torque_offset": ("joint", "j", lambda a, j, s, r: {"T": _sign(r) * s * a.torque[j]}),
    "armature": ("joint", "j", lambda a, j, s, r: {"I": s * a.inertia[j]}),
    "joint_stiffness": ("joint", "j", lambda a, j, s, r: {"k": 2.0 * s * a.torque[j], "q0": r.uniform(-0.4, 0.4)}),
    "motor_weakness": ("actuator", "m", lambda a, j, s, r: {"loss": 0.08 + 0.5 * s}),
    "command_delay": ("actuator", "m", lambda a, j, s, r: {"delay": 0.004 + 0.02 * s}),
    "sensor_bias": ("sensor", "q", lambda a, j, s, r: {"bias": _sign(r) * 0.1 * s}),
    "body_mass": ("body", "link", lambda a, j, s, r: {"dm": s * float(a.model.body(f"link{j + 1}").mass[0])}),
}
"""Kind of element, what its name begins with, and how its parameters are drawn."""
_DRY = {name.partition(".")[0] for name in DRY}
_RUBS = {*_DRY, "load_dependent_friction"}
_SAME = {
    "viscous_friction": {"viscous_friction": "c", "back_emf": "k", "servo_damping": "k"},
    "coulomb_friction": {"coulomb_friction": "T", "stribeck_friction": ""},
    "stribeck_friction": {"stribeck_friction": "T", "coulomb_friction": ""},
    "armature": {"armature": "I", "joint_compliance": "I"},
}
"""Names that say the same at a driven joint, and the parameter that has the first one's value; empty: none has."""


def drawn_effects(arm: Arm, rng: np.random.Generator) -> list[ArmEffect]:
    """Three to eight effects, one of a kind at a joint, one dry friction at a joint."""
    found: dict[tuple[str, int], ArmEffect] = {}
    count = int(rng.integers(_LEAST, _MOST + 1))
    while len(found) < count:
        name, joint = str(rng.choice(list(_KINDS))), int(rng.integers(arm.joints))
        strength = float(np.exp(rng.uniform(np.log(_WEAKEST), np.log(_STRONGEST))))
        taken = _RUBS if name in _RUBS else {name}
        if not any((other, joint) in found for other in taken):
            draw = _KINDS[name][2]
            values = {k: float(v) for k, v in draw(arm, joint, strength, rng).items()}
            found[name, joint] = ArmEffect(name, joint, values)
    return list(found.values())


def said_by(effect: str, parameters: Iterable[str]) -> Mapping[str, str]:
    """Names under which an effect counts as found, and the parameter that has its size: its own first one."""
    return _SAME.get(effect, {effect: next(iter(parameters))})


def accepted(effect: ArmEffect, arm: Arm) -> list[str]:
    """Further names that count as right at the effect's place."""
    shifted = ["joint_offset"] if effect.effect == "sensor_bias" and not arm.servo else []
    return [*(name for name in said_by(effect.effect, effect.parameters) if name != effect.effect), *shifted]


def element(effect: ArmEffect) -> tuple[str, str]:
    """Kind and name of the element that an effect is at."""
    kind, prefix, _ = _KINDS[effect.effect]
    return kind, f"{prefix}{effect.joint + 1}"


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))
