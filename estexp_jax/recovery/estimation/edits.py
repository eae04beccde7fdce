"""The candidate modifications of the simulator: effects at sites, with amounts.

Amounts of the paper's six modifications are those of its genome: a percentage as 0..1, for the tilt -1..1 of 30
degrees. Here a mass may also decrease (negative amounts), which the paper's genome cannot express. Other amounts: the
share of its output that a neuron loses; the share of its friction that the floor loses; a sensor's bias, and the value
at which it is stuck, both relative to its range.

Source: Bongard and Lipson 2004, section 2.2, "The Estimation Phase".
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import final

import mujoco
import numpy as np

from estexp_jax.physics.effects.base import Effect
from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.model.robot import Robot

TILT = np.pi / 6
"""Steepest slope, rad."""
_BIAS, _SWING = 0.5, np.pi / 4
"""Largest bias of an angle sensor, and largest angle at which one is stuck, rad."""

_NO_DIGITS = 12
"""Decimals to which amounts are rounded, after sums and products of multiples of 0.01."""


@final
@dataclass(frozen=True)
class DamageSite:
    """One effect at one element, without an amount.

    Attributes:
        effect: its name.
        name: of the element; None for the environment.
        partner: for a motor that repeats another's command: the other, counted from 1; else 0.
    """

    effect: str
    name: str | None
    partner: int = 0


def damage_sites(robot: Robot, name: str) -> tuple[DamageSite, ...]:
    """The sites of an effect that influence the controller's readings; of sensors, only those that it reads."""
    definition = effect(name)
    sites = definition.sites(robot)
    if definition.kind == "sensor":
        inputs = interface_of(robot).names
        sites = tuple(site for site in sites if site in inputs)
    if name == "tied_outputs":
        motors = range(1, len(sites) + 1)
        return tuple(DamageSite(name, site, p) for i, site in enumerate(sites, start=1) for p in motors if p != i)
    if name == "sensor_bias":  # what is off by a constant has a scale; touch has none
        sites = tuple(site for site in sites if not _is_touch(robot, site))
    return tuple(DamageSite(name, site or None) for site in sites if site != ALL_ALIKE)


def change_of(robot: Robot, place: DamageSite, amount: float) -> Change:
    """The change that an amount at a site stands for.

    Raises:
        ValueError: the effect is none of the modifications.
    """
    match place.effect:
        case "part_lost":
            parameters = {"lost": 1.0}
        case "body_mass":
            parameters = {"dm": amount * float(robot.model.body_mass[robot.index("body", place.name or "")])}
        case "motor_weakness":
            parameters = {"loss": amount}
        case "sensor_gain":
            parameters = {"gain": 1.0 - amount}
        case "joint_jam":
            parameters = {"f": amount}
        case "gravity_tilt":
            parameters = {"angle": amount * TILT}
        case "neuron_fault":
            parameters = {"gain": 1.0 - amount}
        case "tied_outputs":
            parameters = {"with": float(place.partner)}
        case "sensor_bias":
            parameters = {"bias": amount * _BIAS}
        case "sensor_stuck":
            parameters = {"value": amount * (1.0 if _is_touch(robot, place.name or "") else _SWING)}
        case "ground_friction":
            parameters = {"mu": (1.0 - amount) * float(robot.model.geom_friction[:, 0].max())}
        case _:
            raise ValueError(f"'{place.effect}' is none of the modifications")
    return Change(place.effect, place.name, parameters)


def canonical_damage(robot: Robot, items: Iterable[tuple[DamageSite, float]]) -> tuple[tuple[DamageSite, float], ...]:
    """The shortest equivalent hypothesis: sorted, one amount for each site, nothing without effect.

    Losses of strength or sensitivity multiply, of two jams the worse one counts, masses and tilts add up. Damage on a
    lost part is dropped, except for sensors: a lost touch sensor reads -1, and a gain still scales that.
    """
    amounts: dict[DamageSite, float] = {}
    for place, amount in items:
        amounts[place] = _combine(place.effect, amounts[place], amount) if place in amounts else amount
    lost = [robot.index("body", p.name or "") for p in amounts if p.effect == "part_lost"]
    gone = {body for part in lost for body in robot.subtree(part) if body != part}
    parts = gone | set(lost)
    kept = {
        p: round(a, _NO_DIGITS)
        for p, a in amounts.items()
        if not _is_on(robot, p, gone if p.effect == "part_lost" else parts) and (a != 0.0 or p.effect in _AMOUNT_FREE)
    }
    # A motor can repeat one other only: of several, the first is kept.
    once = {(p.effect, p.name): (p, a) for p, a in sorted(kept.items(), key=_order, reverse=True)}
    return tuple(sorted(once.values(), key=_order))


_AMOUNT_FREE = ("part_lost", "sensor_stuck")
"""Effects that act even if the amount is 0."""


def _order(item: tuple[DamageSite, float]) -> tuple[str, str, int]:
    place = item[0]
    return place.effect, place.name or "", place.partner


def _is_touch(robot: Robot, sensor: str) -> bool:
    return int(robot.model.sensor_type[robot.index("sensor", sensor)]) == int(mujoco.mjtSensor.mjSENS_TOUCH)


def _combine(name: str, a: float, b: float) -> float:
    match name:
        case "motor_weakness" | "sensor_gain":
            return 1.0 - (1.0 - a) * (1.0 - b)
        case "joint_jam" | "part_lost" | "tied_outputs" | "ground_friction" | "neuron_fault":
            return max(a, b)
        case "sensor_stuck":
            return a
        case "gravity_tilt":
            return float(np.clip(a + b, -1.0, 1.0))
        case _:
            return a + b


def _is_on(robot: Robot, place: DamageSite, bodies: set[int]) -> bool:
    """Whether a site belongs to one of the bodies."""
    definition: Effect = effect(place.effect)
    model, name = robot.model, place.name or ""
    match definition.kind:
        case "body":
            return robot.index("body", name) in bodies
        case "joint":
            return int(model.jnt_bodyid[robot.index("joint", name)]) in bodies
        case "actuator":
            joint = robot.joint_of_actuator(robot.index("actuator", name))
            return joint is not None and int(model.jnt_bodyid[joint]) in bodies
        case _:
            return False
