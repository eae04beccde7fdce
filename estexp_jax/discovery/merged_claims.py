"""Claims that two forms of one effect make at one place, told as one: their forces add."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from estexp_jax.physics.effects import units
from estexp_jax.physics.effects.changes import Change, sentence_of
from estexp_jax.physics.effects.laws.base import UNKNOWN_LAW
from estexp_jax.physics.effects.registry import effect
from estexp_jax.physics.model.robot import Robot


def merged_claims(robot: Robot, entries: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Entries of `what` in their order, those of one effect at one element as one.

    Of two the amounts add, with their intervals as of independent errors; other numbers are the first one's. It is as
    probable as the more probable of the two. Only amounts of added forces add: other effects stay as they are.

    Args:
        robot: the nominal robot.
        entries: as in `findings.json`.
    """
    found = dict[Any, dict[str, Any]]()
    for n, entry in enumerate(entries):
        adds = entry["effect"] != UNKNOWN_LAW and effect(entry["effect"]).additive
        key = (entry["effect"], entry["name"]) if adds else n
        found[key] = _sum(robot, found[key], entry) if key in found else dict(entry)
    return list(found.values())


def _sum(robot: Robot, one: Mapping[str, Any], other: Mapping[str, Any]) -> dict[str, Any]:
    e = effect(one["effect"])
    amount = e.parameters[0].name
    a, b = one["parameters"][amount], other["parameters"][amount]
    value = a["value"] + b["value"]
    ends = {end: _end(value, (a, b), end) for end in ("low", "high")}
    parameters = {**other["parameters"], **one["parameters"], amount: {**a, "value": value, **ends}}
    change = Change(e.name, one["name"], {name: p["value"] for name, p in parameters.items()})
    return {
        **one,
        "probability": max(one["probability"], other["probability"]),
        "in_mjcf": one["in_mjcf"] and other["in_mjcf"],
        "sentence": units.unit_at(robot, e.kind, change.name, sentence_of(robot, change)),
        "equation": e.equation_with_values(change.parameters),
        "parameters": parameters,
    }


def _end(value: float, terms: Sequence[Mapping[str, Any]], end: str) -> float | None:
    """An end of the sum's interval; unknown where one of the terms' is."""
    if any(t[end] is None for t in terms):
        return None
    reach = math.hypot(*(t[end] - t["value"] for t in terms))
    return value + math.copysign(reach, 1.0 if end == "high" else -1.0)
