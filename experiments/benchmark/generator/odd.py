"""Laws without a name of their own in the package: near relatives of named ones, and laws in no catalogue."""

from __future__ import annotations

from experiments.benchmark.generator import elsewhere, joints, motors_wrong
from experiments.benchmark.generator.kind import Kind, sign

ODD = (
    # near relatives of something in the catalogue
    Kind(
        "unknown_law",
        "joint",
        joints.Asymmetric,
        lambda s, j, z, r: {"T": s * z.torque[j], "a": sign(r) * r.uniform(0.3, 0.7)},
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
"""Kinds without a name."""
