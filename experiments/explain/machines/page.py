"""The page of the real recordings: a table a device, agreement of halves, withheld truths."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from experiments.explain.machines.cases import Plan, agreement, score
from experiments.explain.machines.devices import DEVICES
from experiments.harness.explain_runner import findings_of

_PROVES = (
    "Real recordings have no known truth. They can show that a description is *consistent* (noise is what is left), "
    "*predictive* (recordings that were not fitted come out better) and *repeatable* (disjoint halves name the same). "
    "They cannot show that the named physics is what is in the machine: another law that acts alike on these motions "
    "would score the same. Withheld truths are known because they were put there, and reach only the command and "
    "sensor sides, and what the program was told."
)


def write_page(out: Path, plans: Sequence[Plan]) -> Path:
    """Write `results.json` and `results.md`; gives the latter's path."""
    found = {p.name: findings_of(out, p.name) for p in plans}
    told = [_withheld(p, found) for p in plans if p.withheld]
    halves = _halves(plans, found)
    results = {
        "devices": {p.name: _short(found[p.name]) for p in plans if not p.withheld},
        "halves": halves,
        "withheld": told,
    }
    (out / "results.json").write_text(json.dumps(results, indent=1), encoding="utf-8")
    page = out / "results.md"
    page.write_text("\n".join(_lines(plans, found, halves, told)), encoding="utf-8")
    return page


def _short(findings: dict[str, Any] | None) -> dict[str, Any] | None:
    return None if findings is None else {k: findings[k] for k in ("verdict", "where", "what", "fit", "cost")}


def _withheld(plan: Plan, found: dict[str, dict[str, Any] | None]) -> dict[str, Any]:
    findings, w = found[plan.name], plan.withheld
    assert w is not None
    told = (
        {"found": False, "as": None, "named_first": False, "error": None}
        if findings is None
        else score(w, findings, found.get(plan.base))
    )
    return {"case": plan.name, "truth": w.truth, "ran": findings is not None} | told


def _halves(plans: Sequence[Plan], found: dict[str, dict[str, Any] | None]) -> dict[str, float | None]:
    shared = {}
    for plan in plans:
        a, b = found.get(f"{plan.name}-half0"), found.get(f"{plan.name}-half1")
        if a is not None and b is not None:
            shared[plan.name] = agreement(a, b)
    return shared


def _lines(
    plans: Sequence[Plan],
    found: dict[str, dict[str, Any] | None],
    halves: dict[str, float | None],
    told: list[dict[str, Any]],
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
    lines += [_device(p.name, found[p.name], halves) for p in plans if not p.withheld]
    lines += ["", "Errors: nrmse on recordings that were not fitted, windows of 2 s.", "", "Published:", ""]
    lines += [f"- {d.name}: {sentence}" for d in DEVICES.values() for sentence in d.published]
    ran = [t for t in told if t["ran"]]
    lines += ["", f"## Withheld truth: {sum(t['found'] for t in ran)} of {len(ran)} found", ""]
    lines += [
        "| case | withheld | found | as | named first | value | relative error |",
        "|---|---|---|---|---|---|---|",
    ]
    for t in told:
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


def _device(name: str, findings: dict[str, Any] | None, halves: dict[str, float | None]) -> str:
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
