"""Cases of an opened set again, by the program as it is now: what it has learnt since, and what it has lost.

python experiments/benchmark/repeat.py CASES.json run --workers 2 --most 60   some of them; --resume goes on
python experiments/benchmark/repeat.py CASES.json score                       what there is, case by case beside what was
python experiments/benchmark/repeat.py CASES.json score --publish             ... kept beside the cases, in again.json

An opened set is spent: programs after it have learnt from its misses. It tells whether anything was lost, not how
good a program is. The order of a set is random, so that any number of its first cases is a fair sample.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from experiments.benchmark import outside_catalogue, sealed  # noqa: E402
from experiments.benchmark.scoring.board import board  # noqa: E402
from experiments.benchmark.scoring.judge import Row  # noqa: E402
from experiments.harness.explain_study import CaseSet, row_of  # noqa: E402

Entry = Mapping[str, Any]
_SHARES = {
    "place first, effect visible": "place_first",
    "name first, effect visible": "name_first",
    "... or one that says the same": "name_with_equivalents",
    "laws in no catalogue named wrongly": "wrong_name_outside_catalogue",
}
_TOLD = ("alarm", "detected", "place_first", "name_equivalent", "wrong_name")
"""What makes a case another one than it was."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what is asked; gives the exit code."""
    from estexp_jax.errors import InputError

    asked = list(sys.argv[1:] if arguments is None else arguments)
    if not asked or asked[0].startswith("-"):
        print(__doc__)
        return 0 if asked[:1] in (["-h"], ["--help"]) else 2
    opened = Path(asked[0])
    if not opened.is_file():
        raise InputError("is no file", where=str(opened), right="cases.json of a set in experiments/benchmark/opened")
    return again(opened).main(__doc__, asked[1:])


def again(opened: Path) -> CaseSet:
    """The set that was opened, to be explained anew, without rivals.

    Args:
        opened: its `cases.json`.
    """
    known = json.loads(opened.read_text(encoding="utf-8"))
    before = {row["case"]: row for row in known["rows"] if "answer" in row}
    whole = len(known["rows"]) == sealed.CASES
    return CaseSet(
        name="concealed/again",
        planned=sealed.planned if whole else outside_catalogue.planned,
        parts=("all",),
        seed=known["seed"],
        quick=sealed.QUICK,
        published=opened.with_name("again.json"),
        command=sealed.command,
        write_scores=partial(write_scores, before),
        more=partial(sealed.beside, ()),
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
    from estexp_jax.runs import write_text

    sealed = {case: row["recordings_sha256"] for case, row in before.items() if "recordings_sha256" in row}
    same = [e for e in entries if e["case"] in sealed and e.get("recordings_sha256") in (None, sealed[e["case"]])]
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
        *(_line(told, *(b[name] for b in boards)) for told, name in _SHARES.items()),
        f"| gain, median | {' | '.join(_short(b['gain']['median']) for b in boards)} |",
        "",
        "| case | robot | effect | visible | then | now | gain, then | now |",
        "|---|---|---|---|---|---|---|---|",
        *(_case(a, b) for a, b in zip(then, now, strict=True) if any(getattr(a, n) != getattr(b, n) for n in _TOLD)),
    ]
    page = out / "again.md"
    write_text(page, "\n".join(lines) + "\n")
    return page


def _line(told: str, *shares: Mapping[str, Any]) -> str:
    found = [f"{s['k']} of {s['n']}" for s in shares]
    return f"| {told} | {' | '.join(found)} |"


def _case(then: Row, now: Row) -> str:
    told = [", ".join(r.claimed) if r.verdict == "missing_physics" else r.verdict for r in (then, now)]
    shown = "yes" if now.visible else "no"
    return f"| {' | '.join([now.case, now.robot, now.truth, shown, *told, _short(then.gain), _short(now.gain)])} |"


def _short(x: float | None) -> str:
    return "-" if x is None else f"{x:.2f}"


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
