"""One case of several effects: which were named, which were missed, what was named that is not there."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, final

from experiments.benchmark.scoring.judge import axis, matches
from experiments.explain.several.effects import said_by
from experiments.explain.several.flaws import names_flaw
from experiments.explain.several.real import ERROR
from experiments.harness.explain_study import Entry

SURE = 0.5
"""Probability above which a claim counts."""
_WITHIN = 0.2
"""Relative error up to which a size is right."""
_OF_THE_MODEL = {"body_mass": "dm", "armature": "I", "motor_weakness": "loss"}
"""Effects that say that a value of the model is off, and by how much."""
Claim = Mapping[str, Any]
Answer = Mapping[str, Any]


@final
@dataclass(frozen=True)
class NamedSize:
    """A value of an effect that was named: its relative error, whether its interval holds the truth, None: has none."""

    error: float
    inside: bool | None

    @property
    def right(self) -> bool:
        """Whether it is within 20 %."""
        return self.error <= _WITHIN


@final
@dataclass(frozen=True)
class ArmScore:
    """A case and how it was judged; effects as `effect@element`.

    Attributes:
        case, group, robot, flaw, verdict: what it was; the verdict is `none` where the program gave no findings.
        named, missed: visible effects.
        hidden: effects that nobody could see.
        wrong: claims of more than even odds that are not there.
        of_the_flaw: claims that say the unnamed flaw, as a law or a mount that gives.
        of_the_model: claims that a value of the model is off by no more than twice what all are off by.
        sizes: of effects that were named.
        wall_s: what it took; None where it was resumed.
    """

    case: str
    group: str
    robot: str
    flaw: str
    verdict: str
    named: tuple[str, ...] = ()
    missed: tuple[str, ...] = ()
    hidden: tuple[str, ...] = ()
    wrong: tuple[str, ...] = ()
    of_the_flaw: tuple[str, ...] = ()
    of_the_model: tuple[str, ...] = ()
    sizes: tuple[NamedSize, ...] = field(default=())
    wall_s: float | None = None


def judged(entry: Entry) -> ArmScore:
    """Judge a case; where the program failed, all that was there counts as missed."""
    group, robot = entry["group"], entry["robot"]
    answer, findings = entry.get("answer"), entry.get("findings")
    if answer is None or findings is None:
        truth = tuple(entry["truth"].split("+")) if group == "several" else ()
        return ArmScore(entry["case"], group, robot, "", "none", missed=truth, wall_s=entry["wall_s"])
    claims = [c for c in findings["what"] if (c["probability"] or 0.0) > SURE]
    shown = [(e, _naming(e, k, answer, claims)) for k, e in enumerate(answer["effects"])]
    right = [c for e, own in shown for c in own]
    rest = [c for c in claims if not any(c is r for r in right)]
    flawed = [c for c in rest if names_flaw(c, axis(c, answer), answer["flaw"])]
    slight = [c for c in rest if _is_slight(c, answer)]
    return ArmScore(
        case=entry["case"],
        group=group,
        robot=robot,
        flaw=answer["flaw"]["name"],
        verdict=findings["verdict"],
        named=_labels([e for e, own in shown if e["visible"] and own]),
        missed=_labels([e for e, own in shown if e["visible"] and not own]),
        hidden=_labels([e for e, _ in shown if not e["visible"]]),
        wrong=_labels([c for c in rest if not any(c is x for x in (*flawed, *slight))]),
        of_the_flaw=_labels(flawed),
        of_the_model=_labels(slight),
        sizes=tuple(s for e, own in shown if e["visible"] for s in _sizes(e, own[:1])),
        wall_s=entry["wall_s"],
    )


def _naming(effect: Claim, k: int, answer: Answer, claims: Sequence[Claim]) -> list[Claim]:
    """The claims that say the k-th effect, its own name first."""
    equal = set(answer["equivalents"][k])
    found = [c for c in claims if matches(c, effect, answer, equal)]
    return sorted(found, key=lambda c: c["effect"] != effect["effect"])


def _is_slight(claim: Claim, answer: Answer) -> bool:
    parameter = _OF_THE_MODEL.get(claim["effect"])
    if parameter is None or parameter not in claim["parameters"]:
        return False
    scale = answer["known"].get(claim["name"], 1.0)
    return abs(claim["parameters"][parameter]["value"] or 0.0) <= 2.0 * ERROR * scale


def _sizes(effect: Claim, claims: Sequence[Claim]) -> list[NamedSize]:
    true, found = next(iter(effect["parameters"].values())), []
    for claim in claims:
        parameter = said_by(effect["effect"], effect["parameters"]).get(claim["effect"])
        if not parameter or parameter not in claim["parameters"]:
            continue
        value, low, high = (claim["parameters"][parameter].get(n) for n in ("value", "low", "high"))
        error = float("inf") if value is None else abs(value - true) / abs(true)
        found.append(NamedSize(error, None if low is None or high is None else low <= true <= high))
    return found


def _labels(named: Sequence[Claim]) -> tuple[str, ...]:
    return tuple(f"{c['effect']}@{c['name']}" if c["name"] else c["effect"] for c in named)
