"""Where the mismatch sits: how much of it effects at each place remove, taken singly."""

from __future__ import annotations

from typing import Any

from estexp_jax.discovery.hypotheses import Place
from estexp_jax.discovery.selection import FEWEST_WINDOWS, NOISE, Explanation, Selection, p_value
from estexp_jax.discovery.stuck_sensors import PLAIN
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.effects.sites import ALL_ALIKE
from estexp_jax.physics.model.robot import Robot

_TOLD = 0.02
"""Smallest share worth a line."""
_TIE = 0.99
"""Of what effects at the best place remove: those at a place that remove as much may as well be the guilty ones."""


def where(robot: Robot, selection: Selection) -> list[dict[str, Any]]:
    """Ranked places: kind, name, share of the removable held-out error, p-value against parameters alone.

    The p-value is that of the best of all effects tried, at whatever place, so it is multiplied by their number.

    Of near ties, and where it leaves only noise, what is claimed comes first: all motors weaker, with the others bent
    back, say the same as one. Where what is claimed is plain in the recordings themselves, there is no other place.
    """
    if selection.seen:
        kind, name = element(robot, selection.chosen.places[0])
        return [{"kind": kind, "name": name, "share": 1.0, "p_value": PLAIN}]
    if len(selection.chosen.places) > 1 and not any(len(e.places) == 1 for e in selection.tried):
        return _where_without(robot, selection)
    base = selection.parameters.held_out.sum()
    best: dict[tuple[str, str | None], Explanation] = {}
    for explanation in selection.tried:
        if len(explanation.places) == 1:
            place = element(robot, explanation.places[0])
            if place not in best or explanation.error < best[place].error:
                best[place] = explanation
    removed = {place: max(base - e.held_out.sum(), 0.0) for place, e in best.items()}
    total, tries = sum(removed.values()), sum(len(e.places) == 1 for e in selection.tried)
    claimed, most = {element(robot, place) for place in selection.chosen.places}, max(removed.values(), default=0.0)
    guilty = {p for p in claimed & set(best) if removed[p] >= _TIE * most or best[p].error <= NOISE}
    ranked = sorted(best, key=lambda place: (place in guilty, removed[place]), reverse=True)
    entries = [
        {
            "kind": kind,
            "name": name,
            "share": removed[kind, name] / total,
            "p_value": _corrected(best[kind, name], selection.parameters, tries),
        }
        for kind, name in ranked
        if total > 0.0
    ]
    return [entry for entry in entries if entry["share"] >= _TOLD]


def _corrected(best: Explanation, base: Explanation, tries: int) -> float | None:
    """The p-value of the best of so many; None with too few windows for one."""
    return min(tries * p_value(best, base), 1.0) if len(base.held_out) >= FEWEST_WINDOWS else None


def _where_without(robot: Robot, selection: Selection) -> list[dict[str, Any]]:
    """The same of effects that were never tried singly: by how much leaving out all at a place raises the error."""
    chosen, found = selection.chosen, list[tuple[tuple[str, str | None], float, float | None]]()
    for place in dict.fromkeys(element(robot, p) for p in chosen.places):
        rest = {p for p in chosen.places if element(robot, p) != place}
        for e in selection.tried:
            if set(e.places) == rest:
                found.append(
                    (
                        place,
                        max(e.held_out.sum() - chosen.held_out.sum(), 0.0),
                        _corrected(chosen, e, len(chosen.places)),
                    )
                )
                break
    total = sum(raised for _, raised, _ in found) or 1.0
    ranked = sorted(found, key=lambda entry: entry[1], reverse=True)
    entries = [
        {"kind": p[0], "name": p[1], "share": float(raised / total), "p_value": value} for p, raised, value in ranked
    ]
    return [entry for entry in entries if entry["share"] >= _TOLD]


def element(robot: Robot, place: Place) -> tuple[str, str | None]:
    """Kind and name of the element an effect sits on; motors count as the joint they drive."""
    name, site = place
    kind = effect(name).kind
    if kind == "actuator":
        if site == ALL_ALIKE:
            return kind, site
        joint = robot.joint_of_actuator(robot.index("actuator", site))
        return ("joint", robot.names("joint")[joint]) if joint is not None else ("actuator", site)
    return kind, site or None
