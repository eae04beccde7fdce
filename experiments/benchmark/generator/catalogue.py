"""What can be concealed, and where it fits."""

from __future__ import annotations

import numpy as np

from experiments.benchmark.generator.known import KNOWN
from experiments.benchmark.generator.odd import ODD
from experiments.benchmark.generator.own import OWN
from experiments.benchmark.generator.robots import ROBOTS, Layout, layout
from experiments.benchmark.generator.scales import scales

CATALOGUE = {k.law or k.name: k for k in (*KNOWN, *ODD, *OWN)}
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
OTHERS = tuple(k.law for k in OWN if k.law)
SINGLE = tuple(name for name in CATALOGUE if name not in RELATIVES + UNKNOWN + OTHERS)
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


def parameters(name: str, strength: float, robot: str, joint: int, rng: np.random.Generator) -> dict[str, float]:
    """Parameters of a kind at a joint of a robot."""
    z, place = scales(robot), layout(robot)
    found = {k: float(v) for k, v in CATALOGUE[name].draw(strength, max(joint, 0), z, rng).items()}
    if "source" in found:
        pushing = range(len(place.joints)) if name == "speed_coupling" else sorted(set(place.drives))
        found["source"] = float(rng.choice([j for j in pushing if j != joint]))
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
