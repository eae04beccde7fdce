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

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.damage import Damage
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.model.robot import Robot

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


def damage(name: str) -> Damage:
    """The effect of a name, as a damage.

    Raises:
        ValueError: it is none of the modifications.
    """
    e = effect(name)
    if not isinstance(e, Damage):
        raise ValueError(f"'{name}' is none of the modifications")
    return e


def places(robot: Robot, name: str) -> tuple[Place, ...]:
    """Where an effect can act as far as the controller's readings can tell: of the sensors, only those it reads."""
    e = damage(name)
    read = interface_of(robot).names if e.kind == "sensor" else ()
    sites = [site for site in e.sites(robot) if e.kind != "sensor" or site in read]
    refers = next((p.refers for p in e.parameters if p.refers), "")
    if refers:
        others = list(enumerate(robot.names(refers), start=1))
        return tuple(Place(name, site, i) for site in sites for i, other in others if other != site)
    return tuple(Place(name, site or None) for site in sites if site != ALL_ALIKE and e.damages(robot, site))


def change_of(robot: Robot, place: Place, amount: float) -> Change:
    """The change that an amount at a place stands for."""
    parameters = damage(place.effect).at_amount(robot, place.name or "", amount, place.partner)
    return Change(place.effect, place.name, parameters)


def merged(robot: Robot, items: Iterable[tuple[Place, float]]) -> tuple[tuple[Place, float], ...]:
    """The shortest list of edits that does the same: sorted, one amount a place, nothing without effect.

    Two losses of strength or sensitivity multiply, two jams are the worse one, masses and tilts add up. What sits on a
    lost part is dropped, sensors apart: a lost touch sensor reads -1, and a gain still scales that.
    """
    amounts: dict[Place, float] = {}
    for place, amount in items:
        amounts[place] = damage(place.effect).combine(amounts[place], amount) if place in amounts else amount
    lost = [robot.index("body", p.name or "") for p in amounts if damage(p.effect).removes_part]
    gone = {body for part in lost for body in robot.subtree(part) if body != part}
    parts = gone | set(lost)
    kept = {
        p: round(a, _NO_DIGITS)
        for p, a in amounts.items()
        if not _on(robot, p, gone if damage(p.effect).removes_part else parts)
        and (a != 0.0 or damage(p.effect).acts_at_zero)
    }
    # A motor repeats one other: of several, the first.
    once = {(p.effect, p.name): (p, a) for p, a in sorted(kept.items(), key=_order, reverse=True)}
    return tuple(sorted(once.values(), key=_order))


def _order(item: tuple[Place, float]) -> tuple[str, str, int]:
    place = item[0]
    return place.effect, place.name or "", place.partner


def _on(robot: Robot, place: Place, bodies: set[int]) -> bool:
    """Whether a place goes with one of the bodies."""
    e = effect(place.effect)
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
