"""What is asked of planted cases, beside what was measured."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from estexp_jax.runs import write_text
from experiments.benchmark.scoring.board import told_share
from experiments.benchmark.scoring.judge import Row

_Measured = tuple[str, str, str]
"""What, how much is wanted, what was found."""


def write_scores(out: Path, rows: Sequence[Row], whole: int) -> Path:
    """Score what has been explained of a set; gives the path of the Markdown page.

    Args:
        out: folder of the page.
        rows: cases that have been explained.
        whole: cases of the set.
    """
    page, table = out / "scores.md", measured(rows)
    lines = [f"{len(rows)} of {whole} cases explained.", "", "| | wanted | found |", "|---|---|---|"]
    lines += [f"| {what} | {wanted} | {found} |" for what, wanted, found in table]
    write_text(page, "\n".join([*lines, "", *_missed(rows)]))
    return page


def measured(rows: Sequence[Row]) -> list[_Measured]:
    """Every line that is asked for."""
    still = [r for r in rows if r.robot != "quadruped"]
    single = [r for r in still if r.group == "single"]
    seen, walking = _visible(single), _visible([r for r in rows if r.robot == "quadruped" and r.group == "single"])
    pairs, late = _visible([r for r in still if r.group == "pair"]), _visible([r for r in still if r.group == "onset"])
    quiet = [r for r in still if r.group in ("null", "parameters")]
    weak = [r for r in single if not r.visible]
    return [
        ("effects too weak to be seen", "stated", f"{len(weak)} of {len(single)}"),
        ("right place first", "95 %", told_share(seen, lambda r: r.place_first)),
        ("right name first", "", told_share(seen, lambda r: r.name_first)),
        ("right name first, or one that says the same", "90 %", told_share(seen, lambda r: r.name_equivalent)),
        ("error of parameters, median and 90 %", "5 %, 15 %", _errors(seen)),
        ("true value within its 90 % interval", "80 to 97 %", _covered(seen)),
        ("held-out excess error removed, median", "90 %", _gain(seen)),
        ("better than parameters only", "95 %", _better(seen, "parameters_only")),
        ("better than the placebo", "95 %", _better(seen, "placebo")),
        ("too weak ones: right name first", "", told_share(weak, lambda r: r.name_equivalent)),
        ("alarms where nothing is missing", "2 of 100", told_share(quiet, lambda r: r.alarm)),
        ("two effects: both named", "60 %", told_share(pairs, lambda r: r.named_all)),
        ("two effects: at least one named", "90 %", told_share(pairs, lambda r: r.wrong_name is False)),
        ("two effects: excess removed, median", "75 %", _gain(pairs)),
        ("onset half-way: right name", "", told_share(late, lambda r: r.name_equivalent)),
        ("onset half-way: its error, median", "2 %", _onset(late)),
        ("quadruped: right place first", "90 %", told_share(walking, lambda r: r.place_first)),
        ("quadruped: right name first", "80 %", told_share(walking, lambda r: r.name_equivalent)),
        ("time of a leg or planar arm, median", "", _time(still)),
    ]


def _visible(rows: Sequence[Row]) -> list[Row]:
    return [r for r in rows if r.visible]


def _better(rows: Sequence[Row], rival: str) -> str:
    asked = [r for r in rows if rival in r.errors and "explained" in r.errors]
    return told_share(asked, lambda r: r.errors["explained"] < r.errors[rival])


def _gain(rows: Sequence[Row]) -> str:
    gains = [r.gain if r.gain is not None else 0.0 for r in rows]
    return f"{100 * float(np.median(gains)):.0f} %, quartiles {_quartiles(gains)}" if gains else "-"


def _quartiles(values: Sequence[float]) -> str:
    low, high = np.quantile(values, [0.25, 0.75])
    return f"{100 * low:.0f} and {100 * high:.0f} %"


def _errors(rows: Sequence[Row]) -> str:
    errors = [s.error for r in rows for s in r.sizes]
    if not errors:
        return "-"
    middle, high = np.quantile(errors, [0.5, 0.9])
    return f"{100 * middle:.1f} %, {100 * high:.0f} % ({len(errors)} parameters)"


def _covered(rows: Sequence[Row]) -> str:
    sizes = [s for r in rows for s in r.sizes]
    return f"{sum(s.covered for s in sizes)} of {len(sizes)}" if sizes else "-"


def _onset(rows: Sequence[Row]) -> str:
    errors = [r.onset_error for r in rows if r.onset_error is not None]
    return f"{100 * float(np.median(errors)):.1f} % of the recording ({len(errors)})" if errors else "-"


def _time(rows: Sequence[Row]) -> str:
    walls = [r.wall_s for r in rows if r.wall_s is not None]
    return f"{float(np.median(walls)):.0f} s, longest {max(walls):.0f} s" if walls else "-"


def _missed(rows: Sequence[Row]) -> list[str]:
    """Every visible effect that was not named first, and every alarm."""
    told = [r for r in rows if (r.visible and not r.name_equivalent) or (r.alarm and r.group in ("null", "parameters"))]
    lines = ["| case | robot | what it was | floors | told | gain |", "|---|---|---|---|---|---|"]
    for r in sorted(told, key=lambda r: (r.truth, r.case)):
        said = ", ".join(r.claimed) if r.verdict == "missing_physics" else r.verdict
        gain = "" if r.gain is None else f"{100 * r.gain:.0f} %"
        lines.append(f"| {r.case} | {r.robot} | {r.truth} | {r.shown:.1f} | {said} | {gain} |")
    missed = Counter(r.truth for r in told)
    return ["Missed: " + (", ".join(f"{t} {n}" for t, n in sorted(missed.items())) or "none") + ".", "", *lines, ""]
