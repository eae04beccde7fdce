"""One case: what was found against what is true."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

QUIET = ("null", "parameters")
"""Groups in which every alarm is false."""
THRESHOLD = 3.0
"""Visibility, in noise floors, from which on an effect ought to be found."""
CONVERGED = 3.0
"""Noise floors a refit of parameters may leave in training where nothing is missing."""
NEUTRAL = {"sensor_gain": 1.0}
"""Values of parameters at which an effect does nothing, where that is not zero."""


@dataclass(frozen=True)
class Size:
    """A fitted parameter beside the true one."""

    effect: str
    parameter: str
    true: float
    value: float
    error: float
    covered: bool


@dataclass(frozen=True)
class Row:
    """A case and how it was judged; None where a question does not arise.

    Attributes:
        case, group, robot, truth: what it was; `truth` is the effects' own names joined by +.
        shown: visibility, noise floors. `visible`: at least the threshold.
        verdict: as found; `none` where the program gave no findings.
        claimed: names of the effects found.
        alarm: something beyond parameters was claimed.
        detected: the effect was noticed: an alarm, or its own value named among the parameters.
        place_first, place_three: the joint (motor, sensor and body count as their joint's) was first, or among three.
        name_first: first claim right in name and place; `name_equivalent`: or in a name that says the same.
        named_all: every effect named. `wrong_name`: a name was given and it is none of those that are right.
        sizes: parameters of the effects named right.
        onset_error: median over training recordings, as a share of their length.
        probability: of the first claim.
        gain: held-out gain; `errors`: test nrmse of nominal, parameters_only, explained; `floor` as found.
        converged: where nothing is missing, parameters_only leaves at most 3 floors in training.
        wall_s, robot_steps: cost.
    """

    case: str
    group: str
    robot: str
    truth: str
    shown: float
    visible: bool
    verdict: str
    claimed: tuple[str, ...] = ()
    alarm: bool = False
    detected: bool = False
    place_first: bool | None = None
    place_three: bool | None = None
    name_first: bool | None = None
    name_equivalent: bool | None = None
    named_all: bool | None = None
    wrong_name: bool | None = None
    sizes: tuple[Size, ...] = ()
    onset_error: float | None = None
    probability: float | None = None
    gain: float | None = None
    errors: Mapping[str, float] = field(default_factory=dict)
    floor: float | None = None
    converged: bool | None = None
    wall_s: float | None = None
    robot_steps: float | None = None


_ASKED = ("place_first", "place_three", "name_first", "name_equivalent", "named_all")
"""What a program that failed has not answered: nothing of it is right."""


def judge(case: str, answer: Mapping[str, Any], findings: Mapping[str, Any] | None, wall_s: float | None = None) -> Row:
    """Judge a case.

    Args:
        case: its id.
        answer: what is true.
        findings: what was found; None where the program failed.
        wall_s: how long its process took.
    """
    effects, shown = answer["effects"], answer["visibility"]["shown"]
    truth = "+".join(e["law"] or e["effect"] for e in effects) or answer["group"]
    what: dict[str, Any] = {
        "case": case,
        "group": answer["group"],
        "robot": answer["robot"],
        "truth": truth,
        "shown": shown,
        "visible": bool(effects) and shown >= THRESHOLD,
        "wall_s": wall_s,
    }
    if findings is None:
        return Row(**what, verdict="none", **(dict.fromkeys(_ASKED, False) if effects else {}))
    claims, verdict = findings["what"], findings["verdict"]
    alarm = verdict in ("missing_physics", "unexplained")
    what |= {"verdict": verdict, "alarm": alarm, "claimed": tuple(_label(c) for c in claims)}
    what |= _fit(findings, bool(effects)) | {
        "probability": claims[0]["probability"] if claims and verdict == "missing_physics" else None
    }
    if effects:
        right = [
            [matches(c, e, answer, set(equal)) for e, equal in zip(effects, answer["equivalents"], strict=True)]
            for c in claims
        ]
        exact = [[matches(c, e, answer, set()) for e in effects] for c in claims]
        what |= _names(exact, right, effects, verdict) | _places(findings["where"], effects, answer)
        if what["name_equivalent"] and not what["name_first"]:  # what says the same may sit elsewhere
            what |= {"place_first": True, "place_three": True}
        what["detected"] = alarm or any(any(r) for r in right)
        what["sizes"] = tuple(
            s
            for c, r in zip(claims, exact, strict=True)
            for e, ok in zip(effects, r, strict=True)
            if ok
            for s in _sizes(c, e)
        )
        what["onset_error"] = _onset(findings, answer)
    return Row(**what)


def _label(claim: Mapping[str, Any]) -> str:
    return f"{claim['effect']}@{claim['name']}" if claim["name"] else claim["effect"]


def axis(place: Mapping[str, Any], answer: Mapping[str, Any]) -> str | None:
    """The joint a place belongs to; None for the environment and the like."""
    return answer["axes"].get(f"{place['kind']} {place['name']}")


def _same_place(place: Mapping[str, Any], effect: Mapping[str, Any], answer: Mapping[str, Any]) -> bool:
    if effect["name"] == "*":
        driven = {joint for element, joint in answer["axes"].items() if element.startswith("actuator ")}
        only = len(driven) == 1 and axis(place, answer) in driven  # all motors are at one joint
        return only or place["name"] == "*" or place["kind"] == "actuator"
    if effect["axis"] is None:
        return place["kind"] == effect["kind"]
    return axis(place, answer) == effect["axis"]


def matches(
    claim: Mapping[str, Any], effect: Mapping[str, Any], answer: Mapping[str, Any], equivalents: set[str]
) -> bool:
    """Whether a claim is this effect, or one that says the same."""
    if claim["effect"] in equivalents:
        return True
    if effect["name"] == "*" and claim["effect"] == effect["effect"]:
        return True
    names = {effect["effect"], *effect["accepted"]}
    return claim["effect"] in names and _same_place(claim, effect, answer)


def _names(exact: list[list[bool]], right: list[list[bool]], effects: Any, verdict: str) -> dict[str, Any]:
    unknown = any(e["law"] for e in effects)
    declined = unknown and verdict == "unexplained"
    first, equal = bool(exact) and any(exact[0]), bool(right) and any(right[0])
    return {
        "name_first": first or declined,
        "name_equivalent": equal or declined,
        "named_all": declined or all(any(r[i] for r in right) for i in range(len(effects))),
        "wrong_name": bool(right) and not any(any(r) for r in right),
    }


def _places(where: list[Mapping[str, Any]], effects: Any, answer: Mapping[str, Any]) -> dict[str, bool]:
    hits = [any(_same_place(p, e, answer) for e in effects) for p in where]
    return {"place_first": bool(hits) and hits[0], "place_three": any(hits[:3])}


def _sizes(claim: Mapping[str, Any], effect: Mapping[str, Any]) -> list[Size]:
    found = []
    for name in effect["scored"]:
        if name in claim["parameters"] and claim["effect"] == effect["effect"]:
            fitted, true = claim["parameters"][name], effect["parameters"][name]
            scale = abs(true - NEUTRAL.get(effect["effect"], 0.0)) or 1.0
            bounds = fitted.get("low"), fitted.get("high")
            covered = None not in bounds and bounds[0] <= true <= bounds[1]
            found.append(
                Size(effect["effect"], name, true, fitted["value"], abs(fitted["value"] - true) / scale, covered)
            )
    return found


def _onset(findings: Mapping[str, Any], answer: Mapping[str, Any]) -> float | None:
    errors = []
    for file, true in answer["onset_s"].items():
        if true is not None:
            found = findings["when"]["onset_s"].get(file)
            errors.append(abs((0.0 if found is None else found) - true) / answer["length_s"][file])
    return float(np.median(errors)) if errors else None


def _fit(findings: Mapping[str, Any], missing: bool) -> dict[str, Any]:
    fit = findings["fit"]
    names = [n for n in ("nominal", "parameters_only", "explained", "placebo", "black_box") if fit.get(n)]
    errors = {n: fit[n]["test"] for n in names if fit[n].get("test") is not None}
    own = (fit.get("parameters_only") or {}).get("train")
    converged = None if missing or own is None else own <= CONVERGED * fit["noise_floor"]["train"]
    return {
        "gain": fit["gain"]["value"],
        "errors": errors,
        "floor": fit["noise_floor"]["test"],
        "converged": converged,
        "robot_steps": findings["cost"]["robot_steps"],
    }
