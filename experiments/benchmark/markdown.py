"""The page of a scored set as Markdown: its tables, and its worst cases in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from experiments.benchmark.scoring.judge import Row

_WORST = 10
"""Cases in the gallery."""


def head(public: Mapping[str, Any], scores: Mapping[str, Any]) -> list[str]:
    kind = f"sealed at commit {public['commit']}" if public["commit"] else f"development set, seed {public['seed']}"
    return [
        "# Concealed effects: scores",
        "",
        f"{scores['cases']} of {public['cases']} cases ({kind}; robots {', '.join(public['robots'])}). "
        "Shares stand with 95 % Wilson intervals. *Visible*: the effect leaves at least 3 noise floors on training "
        "and test recordings after all parameters were refitted.",
        "",
        "![scores](scores.png)",
        "",
        "![confusion](confusion.png)",
        "",
    ]


def table(scores: Mapping[str, Any]) -> list[str]:
    shares = (
        ("program failed or took too long", scores["failed"]),
        ("false alarms, nothing missing", scores["false_alarms"]["null"]),
        ("false alarms, parameters off", scores["false_alarms"]["parameters"]),
        ("nothing missing: parameters-only within 3 floors in training", scores["converged"]),
        ("visible: noticed", scores["detected"]),
        ("visible: place first", scores["place_first"]),
        ("visible: place in first three", scores["place_three"]),
        ("visible: name first", scores["name_first"]),
        ("visible: name first, or one that says the same", scores["name_with_equivalents"]),
        ("visible pairs: both named", scores["both_named"]),
        ("laws in no catalogue: wrong name", scores["wrong_name_outside_catalogue"]),
        ("abstains where it should", scores["abstains_where_it_should"]),
        ("abstains where it should not", scores["abstains_where_it_should_not"]),
        ("intervals cover the truth", scores["sizes"]["covered"]),
    )
    lines = ["| | share | interval | cases |", "|---|---|---|---|"]
    lines += [
        f"| {n} | {_percent(s['share'])} | {_percent(s['low'])} to {_percent(s['high'])} | {s['k']} of {s['n']} |"
        for n, s in shares
    ]
    gain, cost = scores["gain"], scores["cost"]
    numbers = (
        ("held-out gain, median", gain["median"]),
        (f"held-out gain as a share of the oracle's, median of {gain['with_oracle']}", gain["median_share_of_oracle"]),
        ("parameter error, median", scores["sizes"]["median"]),
        ("parameter error, 90th percentile", scores["sizes"]["p90"]),
        ("onset error, share of the recording", scores["onset"]["median"]),
        ("expected calibration error", scores["calibration"]["ece"]),
        ("wall time a case, median, s", cost["wall_s"]["median"] if cost["wall_s"] else None),
        ("wall time a case, largest, s", cost["wall_s"]["largest"] if cost["wall_s"] else None),
        ("robot steps a case, median", cost["robot_steps_median"]),
    )
    lines += ["", "| | |", "|---|---|", *(f"| {n} | {_number(x)} |" for n, x in numbers), ""]
    return lines


def baselines(scores: Mapping[str, Any]) -> list[str]:
    if not scores["baselines"]:
        return []
    rows = [
        f"| {n} | {_number(r['gain'])} | {_number(r['explained'])} | {r['cases']} |"
        for n, r in scores["baselines"].items()
    ]
    a = scores["absorbed"]
    absorbed = f"Absorbed stratum: noticed in {a['noticed']} of {a['cases']}; "
    absorbed += f"mujoco.sysid in {a['sysid_noticed']} of {a['sysid_asked']}."
    return [
        "## Baselines on the same cases",
        "",
        "| baseline | median gain | explain's | cases |",
        "|---|---|---|---|",
        *rows,
        "",
        absorbed,
        "",
    ]


def gallery(rows: Sequence[Row], answers: Mapping[str, Any]) -> list[str]:
    """The worst cases, in words."""
    worst = sorted((r for r in rows if badness(r) > 0.0), key=badness, reverse=True)[:_WORST]
    lines = [
        "## Worst cases",
        "",
        "| case | robot | group | concealed | shown | verdict | claimed | gain |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for r in worst:
        truth = r.truth  # all that is known where the program failed
        if r.case in answers:
            effects = answers[r.case]["effects"]
            truth = ", ".join(f"{e['law'] or e['effect']}@{e['name']}" for e in effects) or "nothing"
        claimed = ", ".join(r.claimed) or "-"
        cells = [r.case, r.robot, r.group, truth, f"{r.shown:.1f}", r.verdict, claimed, _number(r.gain)]
        lines.append(f"| {' | '.join(cells)} |")
    return [*lines, ""]


def badness(row: Row) -> float:
    """How wrong a case went; 0 is right."""
    if row.verdict == "none":
        return 5.0
    if row.group in ("null", "parameters"):
        return 4.0 if row.alarm else 0.0
    score = 3.0 * bool(row.wrong_name)
    if row.visible:
        score += 2.0 * (not row.detected) + 1.0 * (not row.place_first) + 1.0 * (not row.name_equivalent)
    return score + (max(0.0, 1.0 - row.gain) * 0.5 if row.visible and row.gain is not None else 0.0)


def _percent(x: float | None) -> str:
    return "-" if x is None else f"{100.0 * x:.1f} %"


def _number(x: float | None) -> str:
    return "-" if x is None else f"{x:.3g}"
