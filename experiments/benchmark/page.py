"""The page of a scored set: `scores.json`, `scores.md`, figures and a gallery of the worst cases."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

from experiments.benchmark.absorbed import is_absorbed
from experiments.benchmark.baselines.logs import gain
from experiments.benchmark.scoring.board import board
from experiments.benchmark.scoring.judge import Row, judge
from experiments.benchmark.sets import open_answers
from experiments.harness.explain_runner import ending_of, findings_of

_WORST = 10
_LOGGED = (
    "cases",
    "failed",
    "false_alarms",
    "detected",
    "place_first",
    "name_first",
    "wrong_name_outside_catalogue",
    "gain",
    "calibration",
)
"""Scores that an opening is logged with."""


def judged(out: Path) -> tuple[list[Row], dict[str, dict[str, Any]]]:
    """All cases of a set that have ended, judged; and the answers.

    Raises:
        Tampered: answers or recordings are not those committed to.
    """
    answers, rows = open_answers(out), []
    for case, answer in answers.items():
        ending = ending_of(out, case)
        if ending is not None:
            findings = findings_of(out, case) if ending["code"] == 0 else None
            rows.append(judge(case, answer, findings, None if ending["resumed"] else ending["wall_s"]))
    return rows, answers


def write_page(out: Path) -> Path:
    """Score a set; gives the path of the Markdown page."""
    rows, answers = judged(out)
    return write_scored(out, _read(out / "commitment.json"), rows, answers, _read(out / "rivals.json"))


def write_scored(
    out: Path,
    public: Mapping[str, Any],
    rows: Sequence[Row],
    answers: Mapping[str, Any],
    rivals: Mapping[str, Any],
) -> Path:
    """Write the page of judged cases into `out/scored/`; gives its path.

    Args:
        out: folder of the set.
        public: its seed, size, robots, and the commit that it was sealed at or None.
        rows: the cases.
        answers: effects and visibility of each.
        rivals: what rivals made of some.
    """
    from experiments.benchmark.figures import draw_confusion, draw_page

    oracle = {case: g for case, r in rivals.items() if (g := r.get("oracle", {}).get("gain") or 0.0) > 0.0}
    scores = board(rows, oracle) | {"absorbed": absorbed(rows, answers, rivals), "rivals": beside(rows, rivals)}
    scored = out / "scored"
    scored.mkdir(parents=True, exist_ok=True)
    told = {"scores": scores, "rows": [asdict(r) for r in rows]}
    (scored / "scores.json").write_text(json.dumps(told, indent=1), encoding="utf-8")
    draw_page(rows, scores, scored / "scores.png")
    draw_confusion(scores, scored / "confusion.png")
    page = scored / "scores.md"
    page.write_text(
        "\n".join([*_head(public, scores), *_table(scores), *_rivals(scores), *_gallery(rows, answers)]),
        encoding="utf-8",
    )
    return page


def log_opening(out: Path, log: Path) -> None:
    """Append the opening of a sealed set to the committed log; a set once opened is spent."""
    log_opened(out, _read(out / "commitment.json"), log)


def log_opened(out: Path, public: Mapping[str, Any], log: Path) -> None:
    """Append to the log that the set in a folder, scored there, was opened."""
    scores = _read(out / "scored" / "scores.json")["scores"]
    short = {k: scores[k] for k in _LOGGED}
    known = {k: public[k] for k in ("commit", "seed", "answers_sha256") if k in public}
    with log.open("a", encoding="utf-8") as file:
        file.write(json.dumps(known | {"scores": short}, sort_keys=True) + "\n")


def absorbed(rows: Sequence[Row], answers: Mapping[str, Any], rivals: Mapping[str, Any]) -> dict[str, Any]:
    """Cases whose training recordings a refit of all parameters explains, though held-out ones show the effect."""
    answered = [r for r in rows if r.case in answers]  # the others failed
    inside = [r for r in answered if is_absorbed(answers[r.case])]
    noticed = [rivals[r.case]["sysid"]["noticed"] for r in inside if "sysid" in rivals.get(r.case, {})]
    return {
        "cases": len(inside),
        "noticed": sum(r.detected for r in inside),
        "sysid_asked": len(noticed),
        "sysid_noticed": sum(noticed),
    }


def beside(rows: Sequence[Row], rivals: Mapping[str, Any]) -> dict[str, Any]:
    """Median held-out gain of each rival and of the explanation, on the visible cases where the rival ran.

    Refitted parameters, the placebo and the black box (a small network trained on the residual force) come with every
    explanation; the others run by themselves.
    """
    pairs: dict[str, list[tuple[float, float]]] = {}
    for r in rows:
        theirs = {name: told.get("gain") for name, told in rivals.get(r.case, {}).items()}
        if r.floor is not None:
            told = {n: e for n, e in r.errors.items() if n != "explained"}
            theirs |= {name: gain(error, r.errors["nominal"], r.floor) for name, error in told.items()}
        for name, theirs_here in theirs.items():
            if r.visible and r.gain is not None and theirs_here is not None:
                pairs.setdefault(name, []).append((theirs_here, r.gain))
    found = {}
    for name, each in sorted(pairs.items()):
        rival, own = np.median(each, axis=0).tolist()
        found[name] = {"cases": len(each), "gain": rival, "explained": own}
    return found


def _head(public: Mapping[str, Any], scores: Mapping[str, Any]) -> list[str]:
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


def _table(scores: Mapping[str, Any]) -> list[str]:
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


def _rivals(scores: Mapping[str, Any]) -> list[str]:
    if not scores["rivals"]:
        return []
    rows = [
        f"| {n} | {_number(r['gain'])} | {_number(r['explained'])} | {r['cases']} |"
        for n, r in scores["rivals"].items()
    ]
    a = scores["absorbed"]
    told = f"Absorbed stratum: noticed in {a['noticed']} of {a['cases']}; "
    told += f"mujoco.sysid in {a['sysid_noticed']} of {a['sysid_asked']}."
    return [
        "## Rivals on the same cases",
        "",
        "| rival | median gain | explain's | cases |",
        "|---|---|---|---|",
        *rows,
        "",
        told,
        "",
    ]


def _gallery(rows: Sequence[Row], answers: Mapping[str, Any]) -> list[str]:
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


def _read(path: Path) -> dict[str, Any]:
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}


def head_commit(repository: Path) -> str:
    """The commit scores are made at."""
    return subprocess.run(
        ["git", "-C", str(repository), "rev-parse", "HEAD"], capture_output=True, text=True, check=True
    ).stdout.strip()
