"""What is asked of arms with several effects and with none, beside what was measured."""

from __future__ import annotations

import statistics
from collections import Counter
from collections.abc import Sequence
from pathlib import Path

from experiments.benchmark.scoring.table import Line, share_text, write_tables
from experiments.explain.several.judging import ArmScore, judged
from experiments.harness.explain_study import Entry


def write_scores(out: Path, entries: Sequence[Entry], whole: int) -> Path:
    """Score what has been explained of a set; gives the path of the Markdown page.

    Args:
        out: folder of the page.
        entries: cases that have been explained.
        whole: cases of the set.
    """
    rows = [judged(entry) for entry in entries]
    tables = {"several effects": at_once(rows), "none": without(rows)}
    return write_tables(out / "scores.md", len(rows), whole, tables, _each(rows))


def at_once(rows: Sequence[ArmScore]) -> list[Line]:
    """Every line that is asked for of cases with several effects."""
    own = [r for r in rows if r.group == "several"]
    there = [(r, name, True) for r in own for name in r.named] + [(r, name, False) for r in own for name in r.missed]
    sizes = [s for r in own for s in r.sizes]
    held = [s for s in sizes if s.inside is not None]
    wrong = sum(len(r.wrong) for r in own)
    lines = [
        ("visible effects named at their place", "80 %", share_text(there, lambda t: t[2])),
        ("effects that change less than 3 noises, or than the flaw", "stated", str(sum(len(r.hidden) for r in own))),
        ("other names above 50 %, a case", ".3", f"{wrong / len(own):.2f}" if own else "-"),
        ("sizes within 20 %", "", share_text(sizes, lambda s: s.right)),
        ("90 % intervals that hold the truth", "87 to 93 %", share_text(held, lambda s: s.inside)),
        ("time, median and longest", "minutes", _time(own)),
    ]
    for robot in sorted({r.robot for r in own}):
        lines.append((f"named: {robot}", "", share_text([t for t in there if t[0].robot == robot], lambda t: t[2])))
    for kind in sorted({name.partition("@")[0] for _, name, _ in there}):
        of_kind = [t for t in there if t[1].partition("@")[0] == kind]
        lines.append((f"named: {kind}", "", share_text(of_kind, lambda t: t[2])))
    return lines


def without(rows: Sequence[ArmScore]) -> list[Line]:
    """Every line that is asked for of cases without effects."""
    own = [r for r in rows if r.group == "nothing"]
    verdicts = ", ".join(f"{v} {n}" for v, n in sorted(Counter(r.verdict for r in own).items()))
    return [
        ("cases with a claim above 50 %", "5 %", share_text(own, lambda r: r.wrong)),
        ("the flaw told as a law or a mount that gives", "", share_text(own, lambda r: r.of_the_flaw)),
        ("values that are slightly off told as such", "", share_text(own, lambda r: r.of_the_model)),
        ("verdicts", "consistent, unexplained", verdicts or "-"),
        ("time, median and longest", "minutes", _time(own)),
    ]


def _time(rows: Sequence[ArmScore]) -> str:
    walls = [r.wall_s for r in rows if r.wall_s is not None]
    return f"{statistics.median(walls):.0f} s, {max(walls):.0f} s" if walls else "-"


def _each(rows: Sequence[ArmScore]) -> list[str]:
    """Every case: what was named, missed and said wrongly."""
    lines = ["| case | arm | flaw | verdict | named | missed | other names | of the flaw | s |"]
    lines.append("|---|---|---|---|---|---|---|---|---|")
    for r in sorted(rows, key=lambda r: r.case):
        cells = [r.case, r.robot, r.flaw, r.verdict]
        cells += [", ".join(names) or "-" for names in (r.named, r.missed, r.wrong, r.of_the_flaw)]
        cells.append("-" if r.wall_s is None else f"{r.wall_s:.0f}")
        lines.append(f"| {' | '.join(cells)} |")
    return [*lines, ""]
