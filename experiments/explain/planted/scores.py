"""What is asked of planted cases, beside what was measured."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from experiments.benchmark.scoring.judge import Row
from experiments.benchmark.scoring.table import (
    Line,
    better_text,
    coverage_text,
    gain_text,
    onset_text,
    share_text,
    size_error_text,
    time_text,
    write_tables,
)
from experiments.harness.explain_study import Entry, row_of


def write_scores(out: Path, entries: Sequence[Entry], whole: int) -> Path:
    """Score what has been explained of a set; gives the path of the Markdown page.

    Args:
        out: folder of the page.
        entries: cases that have been explained.
        whole: cases of the set.
    """
    rows = [row_of(entry) for entry in entries]
    return write_tables(out / "scores.md", len(rows), whole, {"": measured(rows)}, _missed(rows))


def measured(rows: Sequence[Row]) -> list[Line]:
    """Every line that is asked for."""
    still = [r for r in rows if r.robot != "quadruped"]
    single = [r for r in still if r.group == "single"]
    visible, walking = _visible(single), _visible([r for r in rows if r.robot == "quadruped" and r.group == "single"])
    pairs, onsets = (
        _visible([r for r in still if r.group == "pair"]),
        _visible([r for r in still if r.group == "onset"]),
    )
    quiet = [r for r in still if r.group in ("null", "parameters")]
    weak = [r for r in single if not r.visible]
    return [
        ("effects too weak to be seen", "stated", f"{len(weak)} of {len(single)}"),
        ("right place first", "95 %", share_text(visible, lambda r: r.place_first)),
        ("right name first", "", share_text(visible, lambda r: r.name_first)),
        ("right name first, or one that says the same", "90 %", share_text(visible, lambda r: r.name_equivalent)),
        ("error of parameters, median and 90 %", "5 %, 15 %", size_error_text(visible)),
        ("true value within its 90 % interval", "80 to 97 %", coverage_text(visible)),
        ("held-out excess error removed, median", "90 %", gain_text(visible)),
        ("better than parameters only", "95 %", better_text(visible, "parameters_only")),
        ("better than the placebo", "95 %", better_text(visible, "placebo")),
        ("too weak ones: right name first", "", share_text(weak, lambda r: r.name_equivalent)),
        ("alarms where nothing is missing", "2 of 100", share_text(quiet, lambda r: r.alarm)),
        ("two effects: both named", "60 %", share_text(pairs, lambda r: r.named_all)),
        ("two effects: at least one named", "90 %", share_text(pairs, lambda r: r.wrong_name is False)),
        ("two effects: excess removed, median", "75 %", gain_text(pairs)),
        ("onset half-way: right name", "", share_text(onsets, lambda r: r.name_equivalent)),
        ("onset half-way: its error, median", "2 %", onset_text(onsets)),
        ("quadruped: right place first", "90 %", share_text(walking, lambda r: r.place_first)),
        ("quadruped: right name first", "80 %", share_text(walking, lambda r: r.name_equivalent)),
        ("time of a leg or planar arm, median", "", time_text(still)),
    ]


def _visible(rows: Sequence[Row]) -> list[Row]:
    return [r for r in rows if r.visible]


def _missed(rows: Sequence[Row]) -> list[str]:
    """Every visible effect that was not named first, and every alarm."""
    alarms = [r for r in rows if r.alarm and r.group in ("null", "parameters")]
    missed = [r for r in rows if r.visible and not r.name_equivalent] + alarms
    lines = ["| case | robot | what it was | floors | claimed | gain |", "|---|---|---|---|---|---|"]
    for r in sorted(missed, key=lambda r: (r.truth, r.case)):
        said = ", ".join(r.claimed) if r.verdict == "missing_physics" else r.verdict
        gain = "" if r.gain is None else f"{100 * r.gain:.0f} %"
        lines.append(f"| {r.case} | {r.robot} | {r.truth} | {r.shown:.1f} | {said} | {gain} |")
    counts = Counter(r.truth for r in missed)
    return ["Missed: " + (", ".join(f"{t} {n}" for t, n in sorted(counts.items())) or "none") + ".", "", *lines, ""]
