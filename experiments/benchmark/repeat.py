"""Cases of an opened set explained again, by the program as it is now: what it has learnt since, and what it has lost.

python experiments/benchmark/run.py repeat CASES run --workers 2 --most 60   some of them; --resume goes on
python experiments/benchmark/run.py repeat CASES score                       what there is, case by case, then and now
python experiments/benchmark/run.py repeat CASES score --publish             ... rows kept beside the cases

CASES is the cases.parquet of a set in experiments/benchmark/opened. An opened set is spent: programs after it have
learnt from its misses. It says whether anything was lost, not how good a program is. The order of a set is random, so
that any number of its first cases is a fair sample.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from estexp_jax.errors import InputError
from estexp_jax.runs import write_text
from experiments.benchmark import outside_catalogue, sealed
from experiments.benchmark.on_disk import FULL
from experiments.benchmark.scoring.board import board
from experiments.benchmark.scoring.judge import Row
from experiments.harness.explain_study import Entry, ExplainStudy, numbered, row_of
from experiments.harness.rows import read_about, read_rows
from experiments.harness.study import Study

_SHARES = {
    "place first, effect visible": "place_first",
    "name first, effect visible": "name_first",
    "... or one that says the same": "name_with_equivalents",
    "laws in no catalogue named wrongly": "wrong_name_outside_catalogue",
}
_COMPARED = ("alarm", "detected", "place_first", "name_equivalent", "wrong_name")
"""What makes a case another one than it was."""


def main(study: Study, arguments: Sequence[str]) -> int:
    """Do what is asked; gives the exit code."""
    if not arguments or arguments[0].startswith("-"):
        print(__doc__)
        return 0 if arguments[:1] in (["-h"], ["--help"]) else 2
    opened = Path(arguments[0])
    if not opened.is_file():
        right = "cases.parquet of a set in experiments/benchmark/opened"
        raise InputError("is no file", where=str(opened), right=right)
    return repeated(study, opened).main(arguments[1:])


def repeated(study: Study, opened: Path) -> ExplainStudy:
    """The set that was opened, to be explained anew, without baselines.

    Args:
        study: whose results it is among.
        opened: its `cases.parquet`.
    """
    rows = read_rows(opened)
    planned = sealed.planned if len(rows) == FULL else outside_catalogue.planned
    return ExplainStudy(
        study=replace(study, command=f"repeat/{opened.resolve().parent.name}"),
        planned=partial(numbered, planned),
        parts=("all",),
        seed=read_about(opened)["seed"],
        quick=sealed.QUICK,
        published=opened.with_name("repeated.parquet"),
        write_scores=partial(write_scores, {row["case"]: row for row in rows if row.get("answer") is not None}),
        beside=partial(sealed.beside, ()),
    )


def write_scores(before: Mapping[str, Entry], out: Path, entries: Sequence[Entry], whole: int) -> Path:
    """A page: how what was explained again came out then and now; gives its path.

    Args:
        before: rows of the opened set by case.
        out: folder of the page.
        entries: rows of now. Those of other recordings than were sealed, as the generator was mended, are left out, and
            those that failed then; those that fail now, and so have no hash of their recordings, count.
        whole: cases of the set.
    """
    hashes = {case: row["recordings_sha256"] for case, row in before.items() if row.get("recordings_sha256")}
    same = [e for e in entries if e["case"] in hashes and e.get("recordings_sha256") in (None, hashes[e["case"]])]
    then, now = [row_of(before[e["case"]]) for e in same], [row_of(e) for e in same]
    boards = board(then), board(now)
    other = ", ".join(e["case"] for e in entries if e not in same) or "none"
    lines = [
        f"{len(same)} of {whole} cases, at {', '.join(sorted({str(e['commit'])[:7] for e in same}))}; "
        f"left out, as drawn otherwise today or failed then: {other}.",
        "",
        "| | then | now |",
        "|---|---|---|",
        _line("false alarms", *(b["false_alarms"]["all"] for b in boards)),
        *(_line(what, *(b[name] for b in boards)) for what, name in _SHARES.items()),
        f"| gain, median | {' | '.join(_short(b['gain']['median']) for b in boards)} |",
        "",
        "| case | robot | effect | visible | then | now | gain, then | now |",
        "|---|---|---|---|---|---|---|---|",
        *(
            _case(a, b)
            for a, b in zip(then, now, strict=True)
            if any(getattr(a, n) != getattr(b, n) for n in _COMPARED)
        ),
    ]
    page = out / "repeated.md"
    write_text(page, "\n".join(lines) + "\n")
    return page


def _line(what: str, *shares: Mapping[str, Any]) -> str:
    found = [f"{s['k']} of {s['n']}" for s in shares]
    return f"| {what} | {' | '.join(found)} |"


def _case(then: Row, now: Row) -> str:
    claimed = [", ".join(r.claimed) if r.verdict == "missing_physics" else r.verdict for r in (then, now)]
    shown = "yes" if now.visible else "no"
    return f"| {' | '.join([now.case, now.robot, now.truth, shown, *claimed, _short(then.gain), _short(now.gain)])} |"


def _short(x: float | None) -> str:
    return "-" if x is None else f"{x:.2f}"
