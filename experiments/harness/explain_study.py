"""Studies of `explain`: cases that are written, explained and judged one by one, by one scorer.

A case leaves one row; what is published beside the README no machine does again.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar, final

from estexp_jax.errors import InputError
from estexp_jax.runs import versions, write_json
from estexp_jax.runs.fleet import Heartbeat
from experiments.benchmark.generator.__main__ import write_one
from experiments.benchmark.generator.case import Plan
from experiments.benchmark.scoring.judge import Row, Size, judge
from experiments.harness.explain_runner import EXPLAIN, ending_of, explain_case, findings_of
from experiments.harness.rows import read_about, read_rows, write_rows
from experiments.harness.study import ROOT, Study, words

P = TypeVar("P")
Entry = Mapping[str, Any]
"""A row as JSON, with the commit that was at work and what a study keeps beside it."""


def as_users_would(_: object) -> tuple[str, ...]:
    """What explains a case."""
    return (*EXPLAIN, "--no-pictures")


def nothing_beside(*_: object) -> dict[str, Any]:
    """What most studies keep beside a case's row."""
    return {}


@final
@dataclass(frozen=True)
class ExplainStudy(Generic[P]):
    """A kind of set.

    Attributes:
        study: its folder and options.
        planned: (seed, part) -> plans by the ids of their cases, which are those that they have in the whole.
        parts: names of the parts.
        seed: of the reported set; nothing was developed on it.
        quick: seed and part of a small one.
        published: rows of the reported set, beside the README.
        write_scores: (folder, entries, number of cases of the set) -> a page.
        write_case: (folder of the set, id, plan) -> the case's answer, when its recordings are written.
        command: what explains a plan's recordings; it sees these and the nominal model, nothing else.
        beside: (folder of the set, id of a case that was explained, its answer) -> what its entry says beside the row.
        timeout_s: most seconds a case.
    """

    study: Study
    planned: Callable[[int, str], Mapping[str, P]]
    parts: tuple[str, ...]
    seed: int
    quick: tuple[int, str]
    published: Path
    write_scores: Callable[[Path, Sequence[Entry], int], Path]
    write_case: Callable[[Path, str, Any], Mapping[str, Any]] = write_one
    command: Callable[[P], tuple[str, ...]] = as_users_would
    beside: Callable[[Path, str, Mapping[str, Any]], Mapping[str, Any]] = nothing_beside
    timeout_s: float = 1800.0

    def entries(self, out: Path, seed: int) -> dict[str, Entry]:
        """Rows of all cases that have been explained, here or in what is published of the same set, by case."""
        found = read_rows(self.published) if read_about(self.published).get("seed") == seed else []
        found += [json.loads(path.read_text(encoding="utf-8")) for path in (out / "rows").glob("*.json")]
        return {entry["case"]: entry for entry in sorted(found, key=lambda entry: entry["case"])}

    def publish(self, entries: Mapping[str, Entry], seed: int) -> None:
        """Keep rows beside the README."""
        write_rows(self.published, entries.values(), seed=seed, versions=versions())

    def explained(self, out: Path, case: str, plan: P, timeout_s: float) -> None:
        """Write a case, explain it and judge the findings; of the recordings nothing is kept but for a failure.

        Args:
            out: folder of the set.
            case: its id.
            plan: what it is to be.
            timeout_s: most seconds that explaining it may take.
        """
        with Heartbeat(out / "under_way", case) as heartbeat:
            heartbeat.report(0.0, "drawing")
            answer = self.write_case(out, case, plan)
            heartbeat.report(0.2, "explaining")
            explain_case(out, case, timeout_s, self.command(plan))
        ending, findings = ending_of(out, case), findings_of(out, case)
        if ending is None:
            raise KeyboardInterrupt
        wall, right = None if ending["resumed"] else ending["wall_s"], ending["code"] == 0
        entry = asdict(judge(case, answer, findings if right else None, wall)) | {"commit": commit()}
        if right:
            entry |= self.beside(out, case, answer)
        (out / "rows").mkdir(exist_ok=True)
        write_json(out / "rows" / f"{case}.json", entry)
        if right:
            shutil.rmtree(out / "cases" / case)

    def main(self, arguments: Sequence[str] | None = None) -> int:
        """Do what the command line asks; gives the exit code."""
        options = self._parsed(words(arguments))
        if options.step in ("all", "run"):
            self._run(options)
        if options.publish:
            self.publish(self.entries(options.out, options.seed), options.seed)
        if options.step in ("all", "score"):
            self._score(options)
        return 0

    def _parsed(self, arguments: Sequence[str]) -> argparse.Namespace:
        parser = self.study.parser(quick=f"only {self.quick[1]}, of another seed")
        parser.add_argument("step", nargs="?", default="all", choices=["all", "run", "score"])
        parser.add_argument("--seed", type=int, default=None, help="of another set")
        parser.add_argument("--part", choices=self.parts, default=None, help="a part of the set")
        parser.add_argument("--only", nargs="+", default=None, metavar="CASE", help="ids of cases")
        parser.add_argument("--most", type=int, default=None, help="cases of this run; the next one goes on")
        parser.add_argument("--timeout", type=float, default=self.timeout_s, help="most seconds a case")
        options = parser.parse_args(arguments)
        options.out = self.study.results(options.out, *([] if options.out else ["quick" if options.quick else "full"]))
        options.seed = options.seed or (self.quick[0] if options.quick else self.seed)
        options.part = options.part or (self.quick[1] if options.quick else "all")
        if options.publish and (options.quick or options.seed != self.seed):
            parser.error(f"--publish is for the reported set, seed {self.seed}")
        return options

    def _run(self, options: argparse.Namespace) -> None:
        from estexp_jax.runs.fleet import run_all
        from estexp_jax.runs.lock import lock_folder
        from estexp_jax.runs.workers import worker_pool_of

        if any(options.out.iterdir()) and not options.resume:
            right = "--resume goes on with them, --out puts others elsewhere"
            raise InputError("holds results", where=str(options.out), right=right)
        known, plans = self.entries(options.out, options.seed), self.planned(options.seed, options.part)
        asked = {case: plan for case, plan in plans.items() if options.only is None or case in options.only}
        some = [(case, plan) for case, plan in asked.items() if case not in known][: options.most]
        calls = [(self.explained, (options.out, case, plan, options.timeout)) for case, plan in some]
        with lock_folder(options.out), worker_pool_of(options.workers, options.ray, [str(ROOT)]) as crew:
            run_all("cases", calls, crew, options.out / "under_way")

    def _score(self, options: argparse.Namespace) -> None:
        wanted = self.planned(options.seed, options.part)
        entries = [e for case, e in self.entries(options.out, options.seed).items() if case in wanted]
        print(f"scores: {self.write_scores(options.out, entries, len(wanted))}")


def numbered(planned: Callable[[int, str], Sequence[Plan]], seed: int, part: str) -> dict[str, Plan]:
    """The plans of a part of a drawn set by their ids, c000 and so on, which are those that they have in the whole."""
    wanted = {plan.seed for plan in planned(seed, part)}
    return {f"c{i:03d}": plan for i, plan in enumerate(planned(seed, "all")) if plan.seed in wanted}


def row_of(entry: Entry) -> Row:
    """A row as it was before it became JSON."""
    sizes = tuple(Size(**size) for size in entry["sizes"])
    known = {name: value for name, value in entry.items() if name in Row.__dataclass_fields__}
    return Row(**{**known, "sizes": sizes, "claimed": tuple(entry["claimed"])})


def commit() -> str | None:
    """The commit that is at work here; None where nobody can tell."""
    asked = ["git", "-C", str(Path(__file__).parent), "rev-parse", "HEAD"]
    done = subprocess.run(asked, capture_output=True, text=True, check=False)
    return done.stdout.strip() or None
