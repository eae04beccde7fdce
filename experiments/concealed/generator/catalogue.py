"""What can be concealed: each effect's class, where it fits, and its parameters at a strength from 0.03 to 0.7."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from experiments.concealed.generator import elsewhere, joints, motors_wrong
from experiments.concealed.generator.effect import Effect
from experiments.concealed.generator.robots import ROBOTS, Layout, layout
from experiments.concealed.generator.scales import Scales, scales

Draw = Callable[[float, int, Scales, np.random.Generator], dict[str, float]]
"""Parameters from strength, index of the joint, the robot's sizes, random numbers."""


@dataclass(frozen=True)
class Kind:
    """A kind of effect.

    Attributes:
        name: as the answers call it: of the package's list, or `unknown_law`.
        kind: of its place: joint, actuator, sensor, body, environment, numerics.
        make: its class.
        draw: its parameters.
        scored: the parameters whose values are compared.
        accepted: names that count as right beside its own (a near relative has one in the catalogue).
        law: its own name where the catalogue has none.
    """

    name: str
    kind: str
    make: type[Effect]
    draw: Draw
    scored: tuple[str, ...] = ()
    accepted: tuple[str, ...] = ()
    law: str | None = None


def _sign(rng: np.random.Generator) -> float:
    return float(rng.choice([-1.0, 1.0]))


def _motor_limit(name_scales: Scales, j: int) -> float:
    return float(name_scales.peak[j])


CATALOGUE = {
    k.law or k.name: k
    for k in (
        Kind(
            "viscous_friction", "joint", joints.Viscous, lambda s, j, z, r: {"c": s * z.torque[j] / z.speed[j]}, ("c",)
        ),
        Kind("coulomb_friction", "joint", joints.Bristles, lambda s, j, z, r: {"T": s * z.torque[j]}, ("T",)),
        Kind(
            "stribeck_friction",
            "joint",
            joints.Stribeck,
            lambda s, j, z, r: {
                "T": 0.5 * s * z.torque[j],
                "S": s * z.torque[j],
                "w_s": r.uniform(0.15, 0.5) * z.speed[j],
            },
            ("T", "S", "w_s"),
        ),
        Kind("load_dependent_friction", "joint", joints.LoadFriction, lambda s, j, z, r: {"mu": 0.7 * s}, ("mu",)),
        Kind(
            "quadratic_drag", "joint", joints.Drag, lambda s, j, z, r: {"c": s * z.torque[j] / z.speed[j] ** 2}, ("c",)
        ),
        Kind(
            "joint_stiffness",
            "joint",
            joints.Spring,
            lambda s, j, z, r: {"k": s * z.torque[j] / z.amplitude[j], "q0": r.uniform(-0.5, 0.5) * z.amplitude[j]},
            ("k", "q0"),
        ),
        Kind(
            "joint_compliance",
            "joint",
            joints.Rotor,
            lambda s, j, z, r: _compliance(s, j, z),
            ("k",),
        ),
        Kind(
            "cogging",
            "joint",
            joints.Cogging,
            lambda s, j, z, r: {
                "A": s * z.torque[j],
                "n": float(r.integers(3, 9)) * 1.5 / z.amplitude[j] ** 0.5 // 1,
                "phase": r.uniform(0.0, 2.0 * np.pi),
            },
            ("A", "n"),
        ),
        Kind(
            "backlash", "joint", joints.Gap, lambda s, j, z, r: {"half_gap": 0.25 * s * z.amplitude[j]}, ("half_gap",)
        ),
        Kind("armature", "joint", joints.Inertia, lambda s, j, z, r: {"I": 1.5 * s * z.inertia[j]}, ("I",)),
        Kind(
            "joint_limit",
            "joint",
            joints.Wall,
            lambda s, j, z, r: {"low": z.low[j] * 4.0, "high": z.high[j] * (1.0 - 0.8 * s)},
            ("high",),
        ),
        Kind("joint_jam", "joint", joints.Jam, lambda s, j, z, r: {"f": 0.15 + 0.7 * s}, ("f",)),
        Kind(
            "hysteresis",
            "joint",
            joints.Dahl,
            lambda s, j, z, r: {"T": s * z.torque[j], "sigma": s * z.torque[j] / (0.25 * z.amplitude[j])},
            ("T", "sigma"),
        ),
        Kind("crosstalk", "joint", joints.Crosstalk, lambda s, j, z, r: {"g": _sign(r) * s, "source": -1.0}, ("g",)),
        Kind("torque_offset", "joint", joints.Offset, lambda s, j, z, r: {"T": _sign(r) * s * z.torque[j]}, ("T",)),
        Kind("motor_weakness", "actuator", motors_wrong.Weak, lambda s, j, z, r: {"loss": s}, ("loss",)),
        Kind(
            "torque_saturation",
            "actuator",
            motors_wrong.Saturated,
            lambda s, j, z, r: {"limit": z.peak[j] * (1.1 - s)},
            ("limit",),
        ),
        Kind(
            "back_emf", "actuator", motors_wrong.BackEmf, lambda s, j, z, r: {"k": s * z.torque[j] / z.speed[j]}, ("k",)
        ),
        Kind(
            "command_delay",
            "actuator",
            motors_wrong.Delay,
            lambda s, j, z, r: {"delay": round(80.0 * s) * 5e-4 + 1e-3},
            ("delay",),
        ),
        Kind("actuator_lag", "actuator", motors_wrong.Lag, lambda s, j, z, r: {"tau": 0.08 * s}, ("tau",)),
        Kind(
            "dead_band",
            "actuator",
            motors_wrong.DeadBand,
            lambda s, j, z, r: {"half_width": s},
            ("half_width",),
        ),
        Kind(
            "motor_fade",
            "actuator",
            motors_wrong.Fade,
            lambda s, j, z, r: {"loss": min(0.9, 0.1 + s), "tau": r.uniform(1.0, 3.0), "reference": 1.2 * z.torque[j]},
            ("tau",),
        ),
        Kind("tied_outputs", "actuator", motors_wrong.Tied, lambda s, j, z, r: {"source": -1.0}),
        Kind("sensor_gain", "sensor", elsewhere.Gain, lambda s, j, z, r: {"gain": 1.0 + _sign(r) * 0.5 * s}, ("gain",)),
        Kind(
            "sensor_bias",
            "sensor",
            elsewhere.Bias,
            lambda s, j, z, r: {"bias": _sign(r) * 0.6 * s * z.amplitude[j]},
            ("bias",),
        ),
        Kind("sensor_delay", "sensor", elsewhere.Late, lambda s, j, z, r: {"delay": 0.06 * s}, ("delay",)),
        Kind(
            "sensor_stuck",
            "sensor",
            elsewhere.Stuck,
            lambda s, j, z, r: {"value": r.uniform(z.low[j], z.high[j])},
            ("value",),
        ),
        Kind("body_mass", "body", elsewhere.Payload, lambda s, j, z, r: {"dm": s}, ("dm",)),
        Kind(
            "com_shift",
            "body",
            elsewhere.ComShift,
            lambda s, j, z, r: dict(
                zip("xyz", (0.08 * s * r.permutation([1.0, 0.0, 1.0]) * r.choice([-1.0, 1.0], 3)).tolist(), strict=True)
            ),
        ),
        Kind(
            "joint_offset",
            "joint",
            elsewhere.ZeroOffset,
            lambda s, j, z, r: {"offset": _sign(r) * 0.4 * s},
            ("offset",),
        ),
        Kind("part_lost", "body", elsewhere.Lost, lambda s, j, z, r: {}),
        Kind(
            "gravity_tilt",
            "environment",
            elsewhere.Tilt,
            lambda s, j, z, r: {"angle": _sign(r) * 0.4 * s, "axis": 1.0},
            ("angle",),
        ),
        Kind("ground_friction", "environment", elsewhere.Slippery, lambda s, j, z, r: {"mu": 0.7 * (1.0 - s)}, ("mu",)),
        Kind(
            "external_force",
            "environment",
            elsewhere.Push,
            lambda s, j, z, r: dict(zip("xyz", (8.0 * s * _direction(r)).tolist(), strict=True)),
        ),
        Kind("time_step", "numerics", Effect, lambda s, j, z, r: {"times": float(r.integers(3, 6))}),
        # near relatives of something in the catalogue
        Kind(
            "unknown_law",
            "joint",
            joints.Asymmetric,
            lambda s, j, z, r: {"T": s * z.torque[j], "a": _sign(r) * r.uniform(0.3, 0.7)},
            accepted=("coulomb_friction", "torque_offset"),
            law="asymmetric_friction",
        ),
        Kind(
            "unknown_law",
            "joint",
            joints.Smooth,
            lambda s, j, z, r: {"T": s * z.torque[j], "w_s": r.uniform(0.05, 0.4) * z.speed[j]},
            accepted=("coulomb_friction", "stribeck_friction"),
            law="smooth_friction",
        ),
        Kind(
            "unknown_law",
            "actuator",
            motors_wrong.CrookedBand,
            lambda s, j, z, r: {"half_width": s, "ratio": r.uniform(0.1, 0.5)},
            accepted=("dead_band",),
            law="crooked_dead_band",
        ),
        Kind(
            "unknown_law",
            "actuator",
            motors_wrong.SecondLag,
            lambda s, j, z, r: {"tau": 0.05 * s},
            accepted=("actuator_lag", "command_delay"),
            law="second_order_lag",
        ),
        Kind(
            "unknown_law",
            "actuator",
            motors_wrong.SoftLimit,
            lambda s, j, z, r: {"limit": z.peak[j] * (1.3 - s)},
            accepted=("torque_saturation",),
            law="soft_saturation",
        ),
        # laws in no catalogue
        Kind(
            "unknown_law",
            "joint",
            joints.Placed,
            lambda s, j, z, r: {"T": s * z.torque[j], "a": r.uniform(0.6, 0.95), "n": 1.5 / z.amplitude[j]},
            law="friction_along_the_path",
        ),
        Kind(
            "unknown_law",
            "joint",
            joints.Detent,
            lambda s, j, z, r: {"A": 2.0 * s * z.torque[j], "q0": 0.0, "s": 0.4 * z.amplitude[j]},
            law="magnetic_detent",
        ),
        Kind(
            "unknown_law",
            "joint",
            joints.Cubic,
            lambda s, j, z, r: {"k": s * z.torque[j] / z.amplitude[j] ** 3},
            law="cubic_spring",
        ),
        Kind(
            "unknown_law",
            "joint",
            joints.Eddy,
            lambda s, j, z, r: {"T": s * z.torque[j], "w_s": 0.4 * z.speed[j]},
            law="eddy_brake",
        ),
        Kind(
            "unknown_law",
            "joint",
            joints.Swirl,
            lambda s, j, z, r: {"c": s * z.torque[j] / z.speed[j] ** 2, "source": -1.0},
            law="speed_coupling",
        ),
        Kind(
            "unknown_law",
            "joint",
            joints.Pulse,
            lambda s, j, z, r: {"T": s * z.torque[j], "f": r.uniform(0.7, 2.5)},
            law="periodic_push",
        ),
        Kind(
            "unknown_law",
            "actuator",
            motors_wrong.Ripple,
            lambda s, j, z, r: {"limit": z.peak[j] / s},
            law="sagging_supply",
        ),
        Kind(
            "unknown_law",
            "sensor",
            elsewhere.Drift,
            lambda s, j, z, r: {"rate": 0.1 * s * z.amplitude[j]},
            law="drifting_sensor",
        ),
    )
}
"""All kinds by their own names."""

RELATIVES = ("asymmetric_friction", "smooth_friction", "crooked_dead_band", "second_order_lag", "soft_saturation")
UNKNOWN = (
    "friction_along_the_path",
    "magnetic_detent",
    "cubic_spring",
    "eddy_brake",
    "speed_coupling",
    "periodic_push",
    "sagging_supply",
    "drifting_sensor",
)
SINGLE = tuple(name for name in CATALOGUE if name not in RELATIVES + UNKNOWN)
ABSORBABLE = (
    "load_dependent_friction",
    "stribeck_friction",
    "quadratic_drag",
    "torque_saturation",
    "joint_limit",
    "hysteresis",
    "cubic_spring",
    "joint_compliance",
    "coulomb_friction",
)
MASKED = (
    ("motor_weakness", "viscous_friction"),
    ("back_emf", "coulomb_friction"),
    ("body_mass", "torque_offset"),
    ("command_delay", "viscous_friction"),
    ("coulomb_friction", "quadratic_drag"),
    ("sensor_bias", "torque_offset"),
)
"""Pairs at one joint of which one hides the other in part."""

_ONLY = {
    "ground_friction": ("quadruped",),
    "part_lost": ("leg", "quadruped"),
    "gravity_tilt": ("leg", "planar", "cartpole", "arm6", "quadruped"),
    "external_force": ("leg", "arm6", "quadruped", "scara"),
    "time_step": ("planar", "cartpole"),
    "joint_offset": ("leg", "planar", "cartpole", "arm6"),
    "com_shift": ("leg", "planar", "arm6", "cartpole"),
    "joint_stiffness": ("leg", "planar", "arm6", "scara"),
    "tied_outputs": ("leg", "arm6", "quadruped"),
    "crosstalk": ("leg", "planar", "arm6", "scara"),
}


def places(name: str, robot: str) -> list[int]:
    """Indices of the joints (environment and numerics: of a body's joint, or -1) at which a kind fits a robot."""
    kind, place = CATALOGUE[name], layout(robot)
    if robot not in _ONLY.get(name, tuple(ROBOTS)):
        return []
    driven = sorted(set(place.drives))
    if kind.kind in ("environment", "numerics") and name != "external_force":
        return [-1]
    if name in ("external_force", "part_lost"):
        return [len(place.joints) - 1]
    if robot == "cartpole" and name == "joint_offset":
        return [1]
    needs_motor = kind.kind == "actuator" or name in (
        "load_dependent_friction",
        "joint_compliance",
        "backlash",
        "joint_jam",
    )
    if name == "backlash" and robot == "quadruped":
        return driven[:2]
    return driven if needs_motor else list(range(len(place.joints)))


def _compliance(s: float, j: int, z: Scales) -> dict[str, float]:
    inertia = 0.2 * z.inertia[j]
    k = z.torque[j] / (0.4 * s * z.amplitude[j])
    return {"k": k, "d": 0.1 * np.sqrt(k * inertia), "I": inertia}


def _direction(rng: np.random.Generator) -> np.ndarray:
    v = rng.standard_normal(3)
    return v / np.linalg.norm(v)


def parameters(name: str, strength: float, robot: str, joint: int, rng: np.random.Generator) -> dict[str, float]:
    """Parameters of a kind at a joint of a robot."""
    z, place = scales(robot), layout(robot)
    found = {k: float(v) for k, v in CATALOGUE[name].draw(strength, max(joint, 0), z, rng).items()}
    if "source" in found:
        others = [j for j in sorted(set(place.drives)) if j != joint] or [joint]
        found["source"] = float(rng.choice(others))
    if "dm" in found:
        model = ROBOTS[robot].model
        found["dm"] = strength * float(model.body_mass[model.body(body_of(place, joint)).id])
    if "half_width" in found:
        servo = float(ROBOTS[robot].model.actuator_biasprm[place.drives.index(joint), 1]) != 0.0
        found["half_width"] *= 0.2 * z.amplitude[joint] if servo else z.torque[joint]
    return found


def body_of(place: Layout, joint: int) -> str:
    """The body that a joint moves."""
    return place.body[joint]
