"""Where to start the search for each effect's parameters: landscapes have several valleys.

Friction, damping and the like start at a few sizes, orders of magnitude apart. Saturations start between little and
all of the motor's torque, limits at places the joint came to, cogging at many spacings and phases: none of these is
found from far away. A richer law also starts from the solution of the simpler one that it contains.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import final

import numpy as np

from estexp_jax.physics.effects.base import Effect
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot

SHARES = (0.004, 0.04, 0.3)
"""Between neutral and a bound: landscapes differ in scale by orders of magnitude."""

_REBOUND = 0.35
"""Restitution of steel on steel, as gears meet."""
_DAMPED = 0.3
"""Damping ratio of the contact of such gears."""
_STIFF, _SOFT = (0.01, 500.0), (0.3, 33.0)
"""Time constant (s) and frequency (rad/s) of stops that throw a joint back at once, or after they gave way."""

_GRIPS = (0.03, 0.1, 0.25, 0.5, 0.75, 0.93, 1.07, 1.4, 2.5)
"""Shares of the modelled grip: where feet slip, a motion a little farther off is another one."""

Vectors = list[tuple[float, ...]]
"""Values of an effect's parameters, in its order."""
Bounds = Sequence[tuple[float, float]]

RUNGS = {
    "stribeck_friction": "coulomb_friction",
    "hysteresis": "coulomb_friction",
    "stribeck_bristles": "hysteresis",
    "motor_fade": "motor_weakness",
    "joint_stiffness": "torque_offset",
    "quadratic_drag": "viscous_friction",
    "external_force": "body_mass",
    "actuator_lag": "command_delay",
    "joint_compliance": "armature",
    "outer_compliance": "armature",
    "rotor_backlash": "backlash",
    "rebound_limit": "joint_limit",
    "motor_heat": "motor_fade",
}
"""Effect to the simpler one that it contains or nearly equals: compared wherever the richer one is."""


@final
@dataclass(frozen=True, eq=False)
class Seen:
    """What recordings show that starts depend on.

    Attributes:
        low, high: (nq,) where joints were.
        reading: (nsensordata,) median readings, NaN where there is none.
    """

    low: np.ndarray
    high: np.ndarray
    reading: np.ndarray


def starts(robot: Robot, e: Effect, site: str, seen: Seen) -> Vectors:
    """Values to start from, at which an effect is present at a site."""
    bounds = e.bounds(robot, site)
    match e.name:
        case "stribeck_friction":
            return [(s * bounds[0][1], s * bounds[1][1], w) for s, w in product(SHARES, (0.03, 0.2, 0.8))]
        case "stribeck_bristles":
            shares, speeds = (0.01, 0.05, 0.2), (0.03, 0.2, 0.8)
            return [(0.7 * s * bounds[0][1], 0.5 * s * bounds[0][1], w, 2e-3) for s, w in product(shares, speeds)]
        case "load_bristles":
            return [(mu, 2e-3) for mu in (0.03, 0.1, 0.3)]
        case "hysteresis":
            shares, ways = (0.004, 0.02, 0.07, 0.3), (0.0015, 0.01, 0.05, 0.2)
            return [(s * bounds[0][1], s * bounds[0][1] / x) for s, x in product(shares, ways)]
        case "joint_stiffness":
            low, high = _range(robot, site, seen)
            return [(s * bounds[0][1], q) for s, q in product(SHARES, (low, 0.5 * (low + high), high))]
        case "cogging":
            return [(0.05 * bounds[0][1], n, p) for n, p in product(np.arange(2.0, 16.0, 1.5), (-2.1, 0.0, 2.1))]
        case "joint_limit":
            low, high = _range(robot, site, seen)
            inside = [share * (high - low) for share in (0.05, 0.15, 0.3)]
            return [(low + x, bounds[1][1]) for x in inside] + [(bounds[0][0], high - x) for x in inside]
        case "rebound_limit":
            hard = starts(robot, effect("joint_limit"), site, seen)
            return [(*stop, *bounce) for stop, bounce in product(hard, (_STIFF, _SOFT))]
        case "torque_saturation":
            return [(float(x),) for x in np.geomspace(*bounds[0], 8)]
        case "ground_friction":
            grip = float(robot.model.geom_friction[:, 0].max())
            return [(min(max(share * grip, bounds[0][0]), bounds[0][1]),) for share in _GRIPS]
        case "part_lost" | "part_stub":
            return [(1.0,)]
        case "joint_jam":
            return [(f,) for f in (0.55, 0.7, 0.85)]
        case "motor_fade":
            return list(product((0.2, 0.7), (0.5, 2.0, 8.0, 30.0)))
        case "motor_heat":
            return list(product((0.3, 0.7), (0.5, 2.0, 8.0), (0.05, 0.15, 0.4)))
        case "joint_compliance" | "outer_compliance":
            return [(k, 0.1 * bounds[1][1], i) for k, i in product(_spread(bounds[0], 4), _spread(bounds[2], 2))]
        case "rotor_backlash":
            [rotor], plays = _spread(bounds[1], 1), np.geomspace(0.03, 0.5, 5) * bounds[0][1]
            return [(play, rotor, _REBOUND) for play in plays.tolist()]
        case "outer_backlash":
            [rotor], plays = _spread(bounds[1], 1), np.geomspace(0.03, 0.5, 5) * bounds[0][1]
            return [(play, rotor, k, _DAMPED) for play, k in product(plays.tolist(), _spread(bounds[2], 2))]
        case "com_shift" | "external_force":
            return _along_axes(bounds, 0.1)
        case "gravity_tilt":
            return list(product((-0.1, 0.1), (-np.pi / 4, 0.0, np.pi / 4, np.pi / 2)))
        case "sensor_stuck":
            column = int(robot.model.sensor_adr[robot.index("sensor", site)])
            return [(float(np.nan_to_num(seen.reading[column])),)]
        case "crosstalk" | "tied_outputs":
            return _referring(robot, e, site)
        case _:
            return _shares(e, bounds)


def climbed(name: str, simpler: Mapping[str, float], bounds: Bounds) -> Vectors:
    """Values to start a richer law from, within its bounds, of the simpler one's."""
    match name:
        case "rotor_backlash":
            return [(simpler["half_gap"], _spread(bounds[1], 1)[0], e) for e in (0.1, _REBOUND)]
        case "stribeck_friction":
            return [(0.8 * simpler["T"], 0.4 * simpler["T"], w) for w in (0.05, 0.3)]
        case "hysteresis":
            return [(simpler["T"], simpler["T"] / x) for x in (0.0015, 0.01, 0.05)]
        case "stribeck_bristles":
            t, way = simpler["T"], simpler["T"] / simpler["sigma"]
            return [(0.8 * t, 0.4 * t, w, way) for w in (0.05, 0.3)]
        case "joint_compliance" | "outer_compliance":
            inertia = max(simpler["I"], 1e-6)
            return [(inertia * w**2, 0.2 * inertia * w, inertia) for w in (30.0, 60.0, 120.0, 240.0)]
        case "motor_heat":
            return [(simpler["loss"], simpler["tau"], share) for share in (0.6, 0.3, 0.15)]
        case "rebound_limit":
            stop = simpler["low"], simpler["high"]
            return [(*stop, *bounce) for bounce in (*product((0.006, 0.02), (250.0, 1500.0)), _SOFT)]
        case "motor_fade":
            return [(min(max(2.0 * simpler["loss"], 0.05), 0.95), tau) for tau in (1.0, 5.0)]
        case _:
            return []


def lowered(name: str, richer: Mapping[str, float]) -> Vectors:
    """Values to start the simpler law of `RUNGS` from, of the richer one's."""
    match name:
        case "stribeck_friction":
            return [(richer["T"] + share * richer["S"],) for share in (0.0, 0.5, 1.0)]
        case "hysteresis":
            return [(richer["T"],)]
        case "stribeck_bristles":
            return [(t, t / richer["x"]) for t in (richer["T"], richer["T"] + richer["S"])]
        case "motor_fade":
            return [(richer["loss"],), (0.5 * richer["loss"],)]
        case "motor_heat":
            return [(richer["loss"], richer["tau"])]
        case "joint_stiffness":
            return [(richer["k"] * richer["q0"],)]
        case "actuator_lag":
            return [(richer["tau"],)]
        case "joint_compliance" | "outer_compliance":
            return [(richer["I"],)]
        case "rotor_backlash":
            return [(richer["half_gap"],)]
        case "rebound_limit":
            return [(richer["low"], richer["high"])]
        case _:
            return []


def _shares(e: Effect, bounds: Bounds) -> Vectors:
    """All parameters a little, somewhat and strongly towards their bounds."""
    neutral = tuple(p.neutral for p in e.parameters)
    found = []
    for share, side in product(SHARES, (1, 0)):
        moved = tuple(n + share * (b[side] - n) for n, b in zip(neutral, bounds, strict=True))
        if moved != neutral:
            found.append(moved)
    return found


def _range(robot: Robot, joint: str, seen: Seen) -> tuple[float, float]:
    place = int(robot.model.jnt_qposadr[robot.index("joint", joint)])
    return float(seen.low[place]), float(seen.high[place])


def _spread(bound: tuple[float, float], n: int) -> list[float]:
    """Inside a bound, evenly by factors."""
    return np.geomspace(*bound, n + 2)[1:-1].tolist()


def _along_axes(bounds: Bounds, share: float) -> Vectors:
    """One of the first three parameters at a time, to either side."""
    found = []
    for axis, side in product(range(3), (0, 1)):
        values = [0.0] * len(bounds)
        values[axis] = share * bounds[axis][side]
        found.append(tuple(values))
    return found


def _referring(robot: Robot, e: Effect, site: str) -> Vectors:
    """Every other element of the kind that a motor drives, with the other parameter a little to either side."""
    kind = e.parameters[0].refers
    driven = {robot.joint_of_actuator(a) for a in range(robot.model.nu)}
    others = [i for i, name in enumerate(robot.names(kind)) if name != site and (kind != "joint" or i in driven)]
    sizes = [()] if len(e.parameters) == 1 else [(g,) for g in (-0.3, -0.1, 0.1, 0.3)]
    return [(1.0 + i, *size) for i, size in product(others, sizes)]
