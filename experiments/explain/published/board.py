"""The board: what was found on each machine beside what is published, a table that a reader can check."""

from __future__ import annotations

import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, final

from estexp_jax.runs import write_json
from estexp_jax.runs.files import write_text
from experiments.explain.published.values import MACHINES, Machine, PublishedValue
from experiments.harness.explain_study import Entry

_WITHIN = 0.25
"""Relative error up to which a value is right."""
_SURE = 0.5
"""Probability above which a wrong name counts."""


@final
@dataclass(frozen=True)
class Line:
    """One published value beside what was found.

    Attributes:
        machine: its name.
        published: the value.
        found: the finding's effect; None: nothing of the kind at the place.
        value, low, high: found, NaN where nothing is.
    """

    machine: str
    published: PublishedValue
    found: str | None = None
    value: float = float("nan")
    low: float = float("nan")
    high: float = float("nan")

    @property
    def right(self) -> bool:
        """Whether the right kind was named at its joint, in size as published or as the torque's regression has it."""
        return any(abs(self.value - v) <= _WITHIN * abs(v) for v in self._known)

    @property
    def inside(self) -> bool:
        """Whether the interval holds either."""
        return any(self.low <= v <= self.high for v in self._known)

    @property
    def _known(self) -> list[float]:
        return [v for v in (self.published.value, self.published.regression) if v is not None]


def lines_of(machine: Machine, findings: Mapping[str, Any]) -> list[Line]:
    """Each published value with the finding that says it."""
    return [_line(machine, value, findings["what"]) for value in machine.values]


def _line(machine: Machine, value: PublishedValue, claims: Sequence[Mapping[str, Any]]) -> Line:
    for claim in claims:
        for name, found in claim["parameters"].items():
            if f"{claim['effect']}.{name}" in value.kinds and _is_at(machine, value, claim):
                numbers = (found[k] if found[k] is not None else float("nan") for k in ("value", "low", "high"))
                return Line(machine.name, value, claim["effect"], *numbers)
    return Line(machine.name, value)


def _is_at(machine: Machine, value: PublishedValue, claim: Mapping[str, Any]) -> bool:
    """Whether a claim is at a value's element: an actuator stands for its joint where a machine has one of each."""
    lone = len({v.element for v in machine.values}) <= 2
    return (claim["name"] or "") == value.element or (lone and claim["kind"] in ("actuator", "body"))


def wrong_names(machine: Machine, findings: Mapping[str, Any]) -> list[str]:
    """Claims of more than even odds that are neither published nor among what a good answer may name."""
    found = []
    for claim in findings["what"]:
        kinds = {f"{claim['effect']}.{name}" for name in claim["parameters"]}
        known = any(kinds & set(v.kinds) and _is_at(machine, v, claim) for v in machine.values)
        place = f"{claim['effect']}@{claim['name'] or ''}"
        if not known and place not in machine.named and (claim["probability"] or 0.0) > _SURE:
            found.append(place)
    return found


def write_board(out: Path, entries: Sequence[Entry], _: int) -> Path:
    """Write `summary.json` and `board.md` of the machines that have been explained; gives the latter's path."""
    found = {e["case"]: e["findings"] for e in entries if e.get("findings")}
    walls = {e["case"]: e.get("wall_s") for e in entries}
    lines = {name: lines_of(MACHINES[name], f) for name, f in found.items() if name in MACHINES}
    wrong = {name: wrong_names(MACHINES[name], f) for name, f in found.items() if name in MACHINES}
    every = [line for own in lines.values() for line in own]
    named = [line for line in every if line.found]
    errors = {name: found[name]["fit"]["explained"].get("test") for name in lines}
    compared = {n: (errors[n], MACHINES[n].by_hand) for n in lines if errors[n] is not None and MACHINES[n].by_hand}
    summary = {
        "machines": len(lines),
        "published": len(every),
        "right_within_25_percent": sum(line.right for line in every),
        "named": len(named),
        "intervals_that_hold_it": sum(line.inside for line in named),
        "wrong_names_above_half": sum(map(len, wrong.values())),
        "predicts_as_well_as_by_hand": sum(e <= h for e, h in compared.values()),
        "compared_by_hand": len(compared),
        "median_wall_s": statistics.median([w for w in walls.values() if w]) if any(walls.values()) else None,
    }
    write_json(out / "summary.json", summary)
    page = out / "board.md"
    write_text(page, "\n".join(_page(summary, lines, wrong, found, walls)))
    return page


def _page(
    summary: Mapping[str, Any],
    lines: Mapping[str, Sequence[Line]],
    wrong: Mapping[str, Sequence[str]],
    found: Mapping[str, Mapping[str, Any]],
    walls: Mapping[str, float | None],
) -> list[str]:
    page = ["# Real machines against published values", ""]
    page += [
        f"{summary['right_within_25_percent']} of {summary['published']} values named at their place, with the right "
        f"kind, within 25 %; {summary['intervals_that_hold_it']} of {summary['named']} intervals hold them; "
        f"{summary['wrong_names_above_half']} other names above 50 %. The explained simulator predicts the test at "
        f"least as well as the published values put in by hand on {summary['predicts_as_well_as_by_hand']} of "
        f"{summary['compared_by_hand']}.",
        "",
        "| machine | place | published (regression) | found | 90 % interval | within 25 % | inside |",
        "|---|---|---|---|---|---|---|",
    ]
    for name, own in lines.items():
        for line in own:
            p = line.published
            also = "" if p.regression is None else f" ({p.regression:.4g})"
            kind = p.kinds[0].split(".")[0]
            said = "-" if line.found is None else f"{line.found} {line.value:.4g}"
            between = "-" if line.found is None else f"{line.low:.4g} to {line.high:.4g}"
            marks = ["yes" if x else "no" for x in (line.right, line.inside)] if line.found else ["no", "-"]
            page.append(
                f"| {name} | {kind} {p.element} | {p.value:.4g}{also} | {said} | {between} | {' | '.join(marks)} |"
            )
    page += [
        "",
        "| machine | verdict | test error: nominal | by hand | explained | other names | s |",
        "|---|---|---|---|---|---|---|",
    ]
    for name in lines:
        fit, hand, wall = found[name]["fit"], MACHINES[name].by_hand, walls.get(name)
        cells = [name, found[name]["verdict"], _number(fit["nominal"].get("test")), _number(hand)]
        cells += [_number(fit["explained"].get("test")), ", ".join(wrong[name]) or "-", _number(wall)]
        page.append(f"| {' | '.join(cells)} |")
    own = ", ".join(m.name for m in MACHINES.values() if m.own)
    return [*page, "", f"Of {own} nobody published values: theirs are fits by hand of the same recordings.", ""]


def _number(x: float | None) -> str:
    return "-" if x is None else f"{x:.3g}"
