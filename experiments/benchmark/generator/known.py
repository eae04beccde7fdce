"""Effects that the package has a name for, at a strength from 0.03 to 0.7."""

from __future__ import annotations

import numpy as np

from experiments.benchmark.generator import elsewhere, joints, motors_wrong
from experiments.benchmark.generator.effect import Effect
from experiments.benchmark.generator.kind import Kind, sign
from experiments.benchmark.generator.scales import Scales


def _compliance(s: float, j: int, z: Scales) -> dict[str, float]:
    inertia = 0.2 * z.inertia[j]
    k = z.torque[j] / (0.4 * s * z.amplitude[j])
    return {"k": k, "d": 0.1 * np.sqrt(k * inertia), "I": inertia}


def _stop(s: float, low: float, high: float) -> dict[str, float]:
    half = 0.5 * (high - low)
    return {"low": low - 3.0 * half, "high": high - s * half}


def _direction(rng: np.random.Generator) -> np.ndarray:
    v = rng.standard_normal(3)
    return v / np.linalg.norm(v)


KNOWN = (
    Kind("viscous_friction", "joint", joints.Viscous, lambda s, j, z, r: {"c": s * z.torque[j] / z.speed[j]}, ("c",)),
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
    Kind("quadratic_drag", "joint", joints.Drag, lambda s, j, z, r: {"c": s * z.torque[j] / z.speed[j] ** 2}, ("c",)),
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
    Kind("backlash", "joint", joints.Gap, lambda s, j, z, r: {"half_gap": 0.25 * s * z.amplitude[j]}, ("half_gap",)),
    Kind("armature", "joint", joints.Inertia, lambda s, j, z, r: {"I": 1.5 * s * z.inertia[j]}, ("I",)),
    Kind(
        "joint_limit",
        "joint",
        joints.Wall,
        lambda s, j, z, r: _stop(s, z.low[j], z.high[j]),
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
    Kind("crosstalk", "joint", joints.Crosstalk, lambda s, j, z, r: {"g": sign(r) * s, "source": -1.0}, ("g",)),
    Kind("torque_offset", "joint", joints.Offset, lambda s, j, z, r: {"T": sign(r) * s * z.torque[j]}, ("T",)),
    Kind("motor_weakness", "actuator", motors_wrong.Weak, lambda s, j, z, r: {"loss": s}, ("loss",)),
    Kind(
        "torque_saturation",
        "actuator",
        motors_wrong.Saturated,
        lambda s, j, z, r: {"limit": z.peak[j] * (1.1 - s)},
        ("limit",),
    ),
    Kind("back_emf", "actuator", motors_wrong.BackEmf, lambda s, j, z, r: {"k": s * z.torque[j] / z.speed[j]}, ("k",)),
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
    Kind("sensor_gain", "sensor", elsewhere.Gain, lambda s, j, z, r: {"gain": 1.0 + sign(r) * 0.5 * s}, ("gain",)),
    Kind(
        "sensor_bias",
        "sensor",
        elsewhere.Bias,
        lambda s, j, z, r: {"bias": sign(r) * 0.6 * s * z.amplitude[j]},
        ("bias",),
    ),
    Kind("sensor_delay", "sensor", elsewhere.DelayedReading, lambda s, j, z, r: {"delay": 0.06 * s}, ("delay",)),
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
        lambda s, j, z, r: {"offset": sign(r) * 0.4 * s},
        ("offset",),
    ),
    Kind("part_lost", "body", elsewhere.Lost, lambda s, j, z, r: {}),
    Kind(
        "gravity_tilt",
        "environment",
        elsewhere.Tilt,
        lambda s, j, z, r: {"angle": sign(r) * 0.4 * s, "axis": 1.0},
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
)
"""Kinds with a name."""
