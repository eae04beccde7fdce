"""The modifications of a simulator that the estimation chooses from, each with a place and an amount.

An amount of the paper's six is what its genome says: a percentage as 0..1, for the tilt -1..1 of 30 degrees. A mass may
also shrink here (negative amounts), which the paper's genome cannot say. Others: the share of its output that a neuron
loses, of its grip that the floor loses; a sensor's bias and the value it is stuck at, in what it can show.

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
"""Largest bias of an angle sensor, and the angle at which one is stuck at most, rad."""

_NO_DIGITS = 12
"""Decimals at which amounts count as equal, after sums and products of multiples of 0.01."""


@final
@dataclass(frozen=True)
class Place:
    """One effect at one place, still without an amount.

    Attributes:
        effect: its name.
        name: of the element; None for the environment.
        partner: of a motor that repeats another's command: that one, counted from 1; else 0.
    """

    effect: str
    name: str | None
    partner: int = 0


def places(robot: Robot, name: str) -> tuple[Place, ...]:
    """Where an effect can act as far as the controller's readings can tell: of the sensors, only those it reads."""
    e = effect(name)
    sites = e.sites(robot)
    if e.kind == "sensor":
        seen = interface_of(robot).names
        sites = tuple(site for site in sites if site in seen)
    if name == "tied_outputs":
        motors = range(1, len(sites) + 1)
        return tuple(Place(name, site, p) for i, site in enumerate(sites, start=1) for p in motors if p != i)
    if name == "sensor_bias":  # what is off by a constant has a scale; touch has none
        sites = tuple(site for site in sites if not _is_touch(robot, site))
    return tuple(Place(name, site or None) for site in sites if site != ALL_ALIKE)


def change_of(robot: Robot, place: Place, amount: float) -> Change:
    """The change that an amount at a place stands for."""
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


def merged(robot: Robot, items: Iterable[tuple[Place, float]]) -> tuple[tuple[Place, float], ...]:
    """The shortest list of edits that does the same: sorted, one amount a place, nothing without effect.

    Two losses of strength or sensitivity multiply, two jams are the worse one, masses and tilts add up. What sits on a
    lost part is dropped, sensors apart: a lost touch sensor reads -1, and a gain still scales that.
    """
    amounts: dict[Place, float] = {}
    for place, amount in items:
        amounts[place] = _together(place.effect, amounts[place], amount) if place in amounts else amount
    lost = [robot.index("body", p.name or "") for p in amounts if p.effect == "part_lost"]
    gone = {body for part in lost for body in robot.subtree(part) if body != part}
    parts = gone | set(lost)
    kept = {
        p: round(a, _NO_DIGITS)
        for p, a in amounts.items()
        if not _on(robot, p, gone if p.effect == "part_lost" else parts) and (a != 0.0 or p.effect in _WHATEVER)
    }
    # A motor repeats one other: of several, the first.
    once = {(p.effect, p.name): (p, a) for p, a in sorted(kept.items(), key=_order, reverse=True)}
    return tuple(sorted(once.values(), key=_order))


_WHATEVER = ("part_lost", "sensor_stuck")
"""What has an effect whatever its amount."""


def _order(item: tuple[Place, float]) -> tuple[str, str, int]:
    place = item[0]
    return place.effect, place.name or "", place.partner


def _is_touch(robot: Robot, sensor: str) -> bool:
    return int(robot.model.sensor_type[robot.index("sensor", sensor)]) == int(mujoco.mjtSensor.mjSENS_TOUCH)


def _together(name: str, a: float, b: float) -> float:
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


def _on(robot: Robot, place: Place, bodies: set[int]) -> bool:
    """Whether a place goes with one of the bodies."""
    e: Effect = effect(place.effect)
    model, name = robot.model, place.name or ""
    match e.kind:
        case "body":
            return robot.index("body", name) in bodies
        case "joint":
            return int(model.jnt_bodyid[robot.index("joint", name)]) in bodies
        case "actuator":
            joint = robot.joint_of_actuator(robot.index("actuator", name))
            return joint is not None and int(model.jnt_bodyid[joint]) in bodies
        case _:
            return False
