"""What is asked of laws that the catalogue lacks, beside what was measured; and what each one looks like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from estexp_jax.runs import write_text
from experiments.benchmark.scoring.board import told_share
from experiments.explain.out_of_catalogue.figure import draw_laws

_STATES = (
    "joint_compliance",
    "backlash",
    "hysteresis",
    "motor_fade",
    "actuator_lag",
    "command_delay",
    "warming_damper",
)
"""Laws with a memory; the others are static."""
_ALIKE = 1.02
"""Errors whose ratio is less count as the same."""
Entry = Mapping[str, Any]


def write_scores(out: Path, entries: Sequence[Entry], whole: int) -> Path:
    """Score what has been explained of a set; gives the path of the Markdown page, beside which is a figure.

    Args:
        out: folder of the page.
        entries: cases that have been explained.
        whole: cases of the set.
    """
    lines = [f"{len(entries)} of {whole} cases explained.", ""]
    for part, name in (("left_out", "left out of the catalogue"), ("own", "laws of no catalogue")):
        own = [e for e in entries if e["group"] == part]
        lines += [f"| {name} | wanted | found |", "|---|---|---|"]
        lines += [f"| {what} | {wanted} | {found} |" for what, wanted, found in measured(own)]
        lines += [""]
    page = out / "scores.md"
    write_text(page, "\n".join([*lines, *_each(entries)]))
    draw_laws([e for e in entries if e["visible"] and e.get("force")], out / "laws.png")
    return page


def measured(entries: Sequence[Entry]) -> list[tuple[str, str, str]]:
    """Every line that is asked for."""
    seen = [e for e in entries if e["visible"]]
    static = [e for e in seen if e["truth"] not in _STATES]
    forces = [e["force"]["error"] for e in seen if e.get("force")]
    worse = [e for e in entries if e.get("errors") and _worse(e["errors"])]
    return [
        ("too weak to be seen", "stated", f"{len(entries) - len(seen)} of {len(entries)}"),
        ("right place first", "90 %", told_share(seen, lambda e: e["place_first"])),
        ("a wrong name given", "at most 10 %", told_share(seen, wrongly_named)),
        ("gain inside the range, of the true law's, median (static)", "80 %", _of_true(static, "inside")),
        ("gain overall, of the true law's, median (static)", "60 %", _of_true(static, "both")),
        ("error of the force, median", "15 %", f"{100 * np.median(forces):.0f} % ({len(forces)})" if forces else "-"),
        ("predicts the tests worse than the nominal simulator", "0", f"{len(worse)} of {len(entries)}"),
        ("unexplained", "", told_share(seen, lambda e: e["verdict"] == "unexplained")),
    ]


def wrongly_named(entry: Entry) -> bool:
    """Whether a name of the catalogue is given that is neither the effect's nor a relative's."""
    first = entry["claimed"][0].partition("@")[0] if entry["claimed"] else "unknown_law"
    return entry["verdict"] == "missing_physics" and first != "unknown_law" and not entry["name_equivalent"]


def _worse(errors: Mapping[str, float]) -> bool:
    """Whether the nominal simulator predicts better; an explanation that runs away on the tests has no error there."""
    return errors.get("explained", np.inf) > _ALIKE * errors["nominal"]


def _of_true(entries: Sequence[Entry], where: str) -> str:
    shares = []
    for e in entries:
        parts = [e[w] for w in (("inside", "beyond") if where == "both" else (where,)) if e.get(w)]
        known = [p for p in parts if p["true"]]
        shares += [float(np.mean([(p["explained"] or 0.0) / p["true"] for p in known]))] if known else []
    return f"{100 * np.median(shares):.0f} % ({len(shares)})" if shares else "-"


def _each(entries: Sequence[Entry]) -> list[str]:
    """Every case in a line."""
    lines = ["| case | robot | law | floors | told | gain | force off by |", "|---|---|---|---|---|---|---|"]
    for e in sorted(entries, key=lambda e: (e["truth"], e["case"])):
        told = ", ".join(e["claimed"]) if e["verdict"] == "missing_physics" else e["verdict"]
        gain = "-" if e["gain"] is None else f"{e['gain']:.2f}"
        force = f"{100 * e['force']['error']:.0f} %" if e.get("force") else "-"
        lines.append(f"| {e['case']} | {e['robot']} | {e['truth']} | {e['shown']:.1f} | {told} | {gain} | {force} |")
    return lines
