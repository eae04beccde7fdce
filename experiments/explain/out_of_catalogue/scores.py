"""What is asked of laws that the catalogue lacks, beside what was measured; and what each one looks like."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from experiments.benchmark.scoring.table import Line, share_text, write_tables
from experiments.explain.out_of_catalogue.figure import draw_laws
from experiments.harness.explain_study import Entry

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


def write_scores(out: Path, entries: Sequence[Entry], whole: int) -> Path:
    """Score what has been explained of a set; gives the path of the Markdown page, beside which is a figure.

    Args:
        out: folder of the page.
        entries: cases that have been explained.
        whole: cases of the set.
    """
    groups = {"left out of the catalogue": "left_out", "laws of no catalogue": "own"}
    tables = {name: measured([e for e in entries if e["group"] == group]) for name, group in groups.items()}
    draw_laws([e for e in entries if e["visible"] and e.get("force")], out / "laws.png")
    return write_tables(out / "scores.md", len(entries), whole, tables, _each(entries))


def measured(entries: Sequence[Entry]) -> list[Line]:
    """Every line that is asked for."""
    visible = [e for e in entries if e["visible"]]
    static = [e for e in visible if e["truth"] not in _STATES]
    forces = [e["force"]["error"] for e in visible if e.get("force")]
    worse = [e for e in entries if e.get("errors") and _worse(e["errors"])]
    return [
        ("too weak to be seen", "stated", f"{len(entries) - len(visible)} of {len(entries)}"),
        ("right place first", "90 %", share_text(visible, lambda e: e["place_first"])),
        ("a wrong name given", "at most 10 %", share_text(visible, wrongly_named)),
        ("gain inside the range, of the true law's, median (static)", "80 %", _of_true(static, "inside")),
        ("gain overall, of the true law's, median (static)", "60 %", _of_true(static, "both")),
        ("error of the force, median", "15 %", f"{100 * np.median(forces):.0f} % ({len(forces)})" if forces else "-"),
        ("predicts the tests worse than the nominal simulator", "0", f"{len(worse)} of {len(entries)}"),
        ("unexplained", "", share_text(visible, lambda e: e["verdict"] == "unexplained")),
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
    lines = ["| case | robot | law | floors | claimed | gain | force off by |", "|---|---|---|---|---|---|---|"]
    for e in sorted(entries, key=lambda e: (e["truth"], e["case"])):
        said = ", ".join(e["claimed"]) if e["verdict"] == "missing_physics" else e["verdict"]
        gain = "-" if e["gain"] is None else f"{e['gain']:.2f}"
        force = f"{100 * e['force']['error']:.0f} %" if e.get("force") else "-"
        lines.append(f"| {e['case']} | {e['robot']} | {e['truth']} | {e['shown']:.1f} | {said} | {gain} | {force} |")
    return lines
