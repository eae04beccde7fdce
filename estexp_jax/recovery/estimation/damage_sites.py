"""The candidate modifications of the simulator: effects at sites, with amounts.

Amounts of the paper's six modifications are those of its genome: a percentage as 0..1, for the tilt -1..1 of 30
degrees. Here a mass may also decrease (negative amounts), which the paper's genome cannot express. Other amounts: the
share of its output that a neuron loses; the share of its friction that the floor loses; a sensor's bias, and the value
at which it is stuck, both relative to its range.

Source: Bongard and Lipson 2004, section 2.2, "The Estimation Phase".
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, final

from estexp_jax.physics.effects.changes import Change
from estexp_jax.physics.effects.damage import Damage
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.engines.controller_interface import interface_of
from estexp_jax.physics.model.robot import Robot
from estexp_jax.recovery.simulator import DamageSimulator

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


def damage(name: str) -> Damage:
    """The effect of a name, as a damage.

    Raises:
        ValueError: it is none of the modifications.
    """
    found = effect(name)
    if not isinstance(found, Damage):
        raise ValueError(f"'{name}' is none of the modifications")
    return found


def damage_sites(robot: Robot, name: str) -> tuple[DamageSite, ...]:
    """The sites of an effect that influence the controller's readings; of sensors, only those that it reads."""
    modification = damage(name)
    is_sensor = modification.kind == "sensor"
    inputs = interface_of(robot).names if is_sensor else ()
    sites = [site for site in modification.sites(robot) if not is_sensor or site in inputs]
    refers = next((p.refers for p in modification.parameters if p.refers), "")
    if refers:
        others = list(enumerate(robot.names(refers), start=1))
        return tuple(DamageSite(name, site, i) for site in sites for i, other in others if other != site)
    sites = [site for site in sites if site != ALL_ALIKE and modification.damages(robot, site)]
    return tuple(DamageSite(name, site or None) for site in sites)


def change_of(robot: Robot, place: DamageSite, amount: float) -> Change:
    """The change that an amount at a site stands for.

    Raises:
        ValueError: the effect is none of the modifications.
    """
    parameters = damage(place.effect).at_amount(robot, place.name or "", amount, place.partner)
    return Change(place.effect, place.name, parameters)


def changes_of(simulator: DamageSimulator, items: Sequence[tuple[DamageSite, float]]) -> tuple[Any, ...]:
    """The changes of the nominal model that a hypothesis stands for."""
    return tuple(change_of(simulator.robot, place, amount) for place, amount in items)


def canonical_damage(robot: Robot, items: Iterable[tuple[DamageSite, float]]) -> tuple[tuple[DamageSite, float], ...]:
    """The shortest equivalent hypothesis: sorted, one amount for each site, nothing without effect.

    Losses of strength or sensitivity multiply, of two jams the worse one counts, masses and tilts add up. Damage on a
    lost part is dropped, except for sensors: a lost touch sensor reads -1, and a gain still scales that.
    """
    amounts: dict[DamageSite, float] = {}
    for place, amount in items:
        amounts[place] = damage(place.effect).combine(amounts[place], amount) if place in amounts else amount
    lost = [robot.index("body", p.name or "") for p in amounts if effect(p.effect).removes_part]
    gone = {body for part in lost for body in robot.subtree(part) if body != part}
    parts = gone | set(lost)
    kept = {
        p: round(a, _NO_DIGITS)
        for p, a in amounts.items()
        if not _is_on(robot, p, gone if effect(p.effect).removes_part else parts)
        and (a != 0.0 or damage(p.effect).acts_at_zero)
    }
    # A motor can repeat one other only: of several, the first is kept.
    once = {(p.effect, p.name): (p, a) for p, a in sorted(kept.items(), key=_order, reverse=True)}
    return tuple(sorted(once.values(), key=_order))


def _order(item: tuple[DamageSite, float]) -> tuple[str, str, int]:
    place = item[0]
    return place.effect, place.name or "", place.partner


def _is_on(robot: Robot, place: DamageSite, bodies: set[int]) -> bool:
    """Whether a site belongs to one of the bodies."""
    definition = effect(place.effect)
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
