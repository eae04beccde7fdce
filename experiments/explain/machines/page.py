"""The page of the real machines: a table a device, agreement of halves, withheld truths."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from estexp_jax.runs import write_json
from estexp_jax.runs.files import write_text
from experiments.explain.machines.cases import MachineCase, planned
from experiments.explain.machines.devices import DEVICES
from experiments.explain.machines.score import agreement, score
from experiments.harness.explain_study import Entry

Found = Mapping[str, Mapping[str, Any] | None]
"""Findings by case; None where the program failed."""
_PROVES = (
    "Real recordings have no known truth. They can show that a description is *consistent* (noise is what is left), "
    "*predictive* (recordings that were not fitted come out better) and *repeatable* (disjoint halves name the same). "
    "They cannot show that the named physics is what is in the machine: another law that acts alike on these motions "
    "would score the same. Withheld truths are known because they were put there, and reach only the command and "
    "sensor sides, and what the program was given as known."
)


def write_page(out: Path, entries: Sequence[Entry], _: int) -> Path:
    """Write `summary.json` and `results.md` of the cases that have been explained; gives the latter's path."""
    cases = planned(0, "all")
    found = {entry["case"]: entry.get("findings") for entry in entries}
    withheld = [_withheld(case, found) for case in cases.values() if case.withheld]
    halves = _halves(cases, found)
    write_json(out / "summary.json", {"halves": halves, "withheld": withheld})
    page = out / "results.md"
    write_text(page, "\n".join(_lines(cases, found, halves, withheld)))
    return page


def _withheld(case: MachineCase, found: Found) -> dict[str, Any]:
    findings, w = found.get(case.name), case.withheld
    assert w is not None
    truth = None if w.truth is None else [w.truth.effect, w.truth.element, w.truth.parameter, w.truth.value]
    scored = {"found": False, "as": None, "named_first": False, "error": None}
    if findings is not None:
        scored = score(w, findings, found.get(case.base))
    return {"case": case.name, "truth": truth, "ran": findings is not None} | scored


def _halves(cases: Mapping[str, MachineCase], found: Found) -> dict[str, float | None]:
    shared = {}
    for name in cases:
        a, b = found.get(f"{name}-half0"), found.get(f"{name}-half1")
        if a is not None and b is not None:
            shared[name] = agreement(a, b)
    return shared


def _lines(
    cases: Mapping[str, MachineCase],
    found: Found,
    halves: Mapping[str, float | None],
    withheld: Sequence[Mapping[str, Any]],
) -> list[str]:
    lines = ["# Real recordings", "", _PROVES, "", "## Devices", ""]
    head = (
        "case",
        "verdict",
        "effects",
        "nominal",
        "parameters only",
        "black box",
        "explained",
        "floor",
        "halves agree",
    )
    lines += [f"| {' | '.join(head)} |", "|---" * len(head) + "|"]
    lines += [_device(name, found.get(name), halves) for name, case in cases.items() if not case.withheld]
    lines += ["", "Errors: nrmse on recordings that were not fitted, windows of 2 s.", "", "Published:", ""]
    lines += [f"- {d.name}: {sentence}" for d in DEVICES.values() for sentence in d.published]
    ran = [t for t in withheld if t["ran"]]
    lines += ["", f"## Withheld truth: {sum(t['found'] for t in ran)} of {len(ran)} found", ""]
    lines += [
        "| case | withheld | found | as | named first | value | relative error |",
        "|---|---|---|---|---|---|---|",
    ]
    for t in withheld:
        truth = (
            "nothing" if t["truth"] is None else f"{t['truth'][0]}@{t['truth'][1]} {t['truth'][2]} = {t['truth'][3]:g}"
        )
        cells = (
            t["case"],
            truth,
            t["found"] if t["ran"] else "not run",
            t.get("as") or "-",
            t["named_first"],
            _number(t.get("value")),
            _number(t["error"]),
        )
        lines.append(f"| {' | '.join(map(str, cells))} |")
    return [*lines, ""]


def _device(name: str, findings: Mapping[str, Any] | None, halves: Mapping[str, float | None]) -> str:
    if findings is None:
        return f"| {name} | not run | | | | | | | |"
    fit = findings["fit"]
    effects = "; ".join(
        f"{c['effect']}@{c['name']} " + ", ".join(f"{k} = {_number(v['value'])}" for k, v in c["parameters"].items())
        for c in findings["what"]
    )
    errors = [_number((fit.get(n) or {}).get("test")) for n in ("nominal", "parameters_only", "black_box", "explained")]
    cells = [
        name,
        findings["verdict"],
        effects or "-",
        *errors,
        _number(fit["noise_floor"]["test"]),
        _number(halves.get(name)),
    ]
    return f"| {' | '.join(cells)} |"


def _number(x: float | None) -> str:
    return "-" if x is None else f"{x:.3g}"
