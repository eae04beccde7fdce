"""How a case of a real machine is scored: by the judge of all sets, and the value of a withheld truth beside it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from experiments.benchmark.scoring.judge import NEUTRAL, matches
from experiments.explain.machines.devices import DEVICES
from experiments.explain.machines.withheld import Truth, Withheld

Findings = Mapping[str, Any]


def answer_of(withheld: Withheld | None, device: str) -> dict[str, Any]:
    """What is true of a case, as the judge takes it; its visibility was not measured."""
    truth = withheld.truth if withheld else None
    group = "withheld" if withheld else "recorded"
    return _answer(truth, device) | {"group": group, "robot": device, "visibility": {"shown": 0.0}}


def _answer(truth: Truth | None, device: str) -> dict[str, Any]:
    """Where a device has but one motor, all motors are that one."""
    if truth is None:
        return {"effects": [], "equivalents": [], "axes": {}, "onset_s": {}, "length_s": {}}
    lone = sum(column.startswith("ctrl.") for column in DEVICES[device].columns) == 1
    effect = {
        "effect": truth.effect, "law": None, "kind": truth.kind, "name": truth.element, "axis": truth.element,
        "accepted": [], "scored": [truth.parameter], "parameters": {truth.parameter: truth.value},
    }  # fmt: skip
    axes = dict.fromkeys([f"{truth.kind} {truth.element}", *([f"{truth.kind} *"] if lone else [])], truth.element)
    return {"effects": [effect], "equivalents": [[]], "axes": axes, "onset_s": {}, "length_s": {}}


def score(withheld: Withheld, findings: Findings, base: Findings | None) -> dict[str, Any]:
    """Whether a withheld truth was found.

    Args:
        withheld: what it is.
        findings: of the changed logs.
        base: findings of the logs as they are; what they claim of the same parameter already is taken off.

    Returns:
        found (its effect, or one that says the same, is claimed at its place, or at all motors where there is but one),
        as (which one), named_first, value and error relative to the truth.
    """
    if withheld.truth is None:
        same = base is not None and claims(findings) == claims(base)
        return {"found": same or findings["verdict"] == (base or {}).get("verdict"), "named_first": None, "error": None}
    first = findings["what"][0] if findings["what"] else {}
    for truth in (withheld.truth, withheld.same):
        own, before = (_value(f, truth, withheld.device) for f in (findings, base))
        if truth is None or own is None:
            continue
        neutral = NEUTRAL.get(truth.effect, 0.0)
        expected = _combined(truth.effect, neutral if before is None else before, truth.value)
        return {
            "found": True,
            "as": f"{truth.effect}@{truth.element}",
            "named_first": (first.get("effect"), first.get("name")) == (truth.effect, truth.element),
            "value": own,
            "error": abs(own - expected) / abs(truth.value - neutral),
        }
    return {"found": False, "as": None, "named_first": False, "value": None, "error": None}


def _combined(effect: str, before: float, added: float) -> float:
    """The value to be found where one was already there: gains and losses multiply, the rest adds."""
    if effect == "motor_weakness":
        return 1.0 - (1.0 - before) * (1.0 - added)
    return before * added if effect == "sensor_gain" else before + added


def _value(findings: Findings | None, truth: Truth | None, device: str) -> float | None:
    """The value that is claimed of a truth."""
    if findings is None or truth is None:
        return None
    answer = _answer(truth, device)
    right = (c for c in findings["what"] if matches(c, answer["effects"][0], answer, set()))
    return next((c["parameters"][truth.parameter]["value"] for c in right), None)


def claims(findings: Findings) -> set[str]:
    """What was claimed, as effect@name."""
    return {f"{c['effect']}@{c['name']}" for c in findings["what"]}


def agreement(a: Findings, b: Findings) -> float | None:
    """Share of all effects named on two halves that both name; None where neither names any."""
    one, other = claims(a), claims(b)
    return len(one & other) / len(one | other) if one | other else None
