"""The page of a scored set: `scores.json`, `scores.md`, figures and a gallery of the worst cases."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from itertools import chain
from pathlib import Path
from typing import Any

from experiments.benchmark import markdown
from experiments.benchmark.scoring.board import board
from experiments.benchmark.scoring.comparison import absorbed, beside
from experiments.benchmark.scoring.judge import Row, judge
from experiments.benchmark.sets import open_answers
from experiments.harness.explain_runner import ending_of, findings_of

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
    return write_scored(out, _read(out / "commitment.json"), rows, answers, _read(out / "baselines.json"))


def write_scored(
    out: Path,
    public: Mapping[str, Any],
    rows: Sequence[Row],
    answers: Mapping[str, Any],
    baselines: Mapping[str, Any],
) -> Path:
    """Write the page of judged cases into `out/scored/`; gives its path.

    Args:
        out: folder of the set.
        public: its seed, size, robots, and the commit that it was sealed at or None.
        rows: the cases.
        answers: effects and visibility of each.
        baselines: what these made of some.
    """
    from experiments.benchmark.figures import draw_confusion, draw_page

    oracle = {case: g for case, r in baselines.items() if (g := r.get("oracle", {}).get("gain") or 0.0) > 0.0}
    scores = board(rows, oracle) | {
        "absorbed": absorbed(rows, answers, baselines),
        "baselines": beside(rows, baselines),
    }
    scored = out / "scored"
    scored.mkdir(parents=True, exist_ok=True)
    result = {"scores": scores, "rows": [asdict(r) for r in rows]}
    (scored / "scores.json").write_text(json.dumps(result, indent=1), encoding="utf-8")
    draw_page(rows, scores, scored / "scores.png")
    draw_confusion(scores, scored / "confusion.png")
    page = scored / "scores.md"
    parts = markdown.head(public, scores), markdown.table(scores), markdown.baselines(scores)
    page.write_text("\n".join([*chain(*parts), *markdown.gallery(rows, answers)]), encoding="utf-8")
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


def _read(path: Path) -> dict[str, Any]:
    return json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
