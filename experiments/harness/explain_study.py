"""Sets of concealed cases that are drawn, explained and judged one by one: what `planted` and `unnamed` share.

A case leaves one entry, its row of scores; what is published beside the README no machine does again.
"""

from __future__ import annotations

import argparse
import json
import shutil
import subprocess
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, final

from estexp_jax.errors import InputError
from estexp_jax.runs import versions, write_json
from estexp_jax.runs.fleet import Beat
from experiments.benchmark.generator.__main__ import write_one
from experiments.benchmark.generator.case import Plan
from experiments.benchmark.scoring.judge import Row, Size, judge
from experiments.harness.explain_runner import ending_of, explain_case, findings_of
from experiments.harness.options import ROOT

Entries = dict[str, dict[str, Any]]
"""Rows by the ids of their cases."""
More = Callable[[Path, str, dict[str, Any]], dict[str, Any]]
"""(folder of the set, id of a case that was explained, its answer) -> what its entry says beside the row."""


@final
@dataclass(frozen=True)
class CaseSet:
    """A kind of set.

    Attributes:
        name: of its experiment.
        planned: seed and part to plans.
        parts: names of the parts.
        seed: of the reported set; nothing was developed on it.
        quick: seed and part of a small one.
        published: what is known of the reported set.
        command: what explains a plan's recordings; it sees these and the nominal model, nothing else.
        write_scores: (folder, entries, number of cases of the set) -> a page.
        more: beside the row; None: nothing.
    """

    name: str
    planned: Callable[[int, str], list[Plan]]
    parts: tuple[str, ...]
    seed: int
    quick: tuple[int, str]
    published: Path
    command: Callable[[Plan], tuple[str, ...]]
    write_scores: Callable[[Path, Sequence[Mapping[str, Any]], int], Path]
    more: More | None = None

    def numbered(self, seed: int, part: str) -> dict[str, Plan]:
        """The plans of a part of a set by their ids, which are those that they have in the whole."""
        wanted = {plan.seed for plan in self.planned(seed, part)}
        return {f"c{i:03d}": plan for i, plan in enumerate(self.planned(seed, "all")) if plan.seed in wanted}

    def entries(self, out: Path, seed: int) -> Entries:
        """Rows of all cases that have been explained, here or in what is published of the same set."""
        known = json.loads(self.published.read_text(encoding="utf-8")) if self.published.is_file() else {}
        found = list(known["rows"]) if known.get("seed") == seed else []
        found += [json.loads(path.read_text(encoding="utf-8")) for path in (out / "rows").glob("c*.json")]
        return {entry["case"]: entry for entry in sorted(found, key=lambda entry: entry["case"])}

    def publish(self, entries: Entries, seed: int) -> None:
        """Keep rows beside the README."""
        write_json(self.published, {"seed": seed, "versions": versions(), "rows": list(entries.values())})

    def explained(self, out: Path, case: str, plan: Plan, timeout: float) -> None:
        """Draw a case, explain it and judge the findings; of the recordings nothing is kept but for a failure.

        Args:
            out: folder of the set.
            case: its id.
            plan: what it is to be.
            timeout: most seconds that explaining it may take.
        """
        with Beat(out / "under_way", case) as beat:
            beat.tell(0.0, "drawing")
            answer = write_one(out, case, plan)
            beat.tell(0.2, "explaining")
            explain_case(out, case, timeout, self.command(plan))
        ending, findings = ending_of(out, case), findings_of(out, case)
        if ending is None:
            raise KeyboardInterrupt
        wall, right = None if ending["resumed"] else ending["wall_s"], ending["code"] == 0
        entry = asdict(judge(case, answer, findings if right else None, wall)) | {"commit": commit()}
        if self.more is not None and right:
            entry |= self.more(out, case, answer)
        (out / "rows").mkdir(exist_ok=True)
        write_json(out / "rows" / f"{case}.json", entry)
        if right:
            shutil.rmtree(out / "cases" / case)

    def main(self, about: str | None, arguments: Sequence[str] | None = None) -> int:
        """Do what the command line asks; gives the exit code."""
        options = self._parsed(about, sys.argv[1:] if arguments is None else arguments)
        if options.step in ("all", "run"):
            self._run(options)
        if options.publish:
            self.publish(self.entries(options.out, options.seed), options.seed)
        if options.step in ("all", "score"):
            self._score(options)
        return 0

    def _parsed(self, about: str | None, arguments: Sequence[str]) -> argparse.Namespace:
        parser = argparse.ArgumentParser(self.name, description=about, formatter_class=argparse.RawTextHelpFormatter)
        parser.add_argument("step", nargs="?", default="all", choices=["all", "run", "score"])
        parser.add_argument("--quick", action="store_true", help=f"only {self.quick[1]}, of another seed")
        parser.add_argument("--resume", action="store_true", help="go on with what an earlier run left")
        parser.add_argument("--workers", type=int, default=None, help="cases at a time; default 1")
        parser.add_argument(
            "--ray", nargs="?", const="local", default=None, metavar="ADDRESS", help="cases as Ray tasks"
        )
        parser.add_argument("--out", type=Path, default=None, help="folder of the set")
        parser.add_argument("--seed", type=int, default=None, help="of another set")
        parser.add_argument("--part", choices=self.parts, default=None, help="a part of the set")
        parser.add_argument("--most", type=int, default=None, help="cases of this run; the next one goes on")
        parser.add_argument(
            "--publish", action="store_true", help="keep the rows beside the README: any machine goes on"
        )
        parser.add_argument("--timeout", type=float, default=1800.0, help="most seconds a case")
        options = parser.parse_args(arguments)
        options.out = (options.out or ROOT / "out" / self.name / ("quick" if options.quick else "full")).resolve()
        options.seed = options.seed or (self.quick[0] if options.quick else self.seed)
        options.part = options.part or (self.quick[1] if options.quick else "all")
        if options.publish and (options.quick or options.seed != self.seed):
            parser.error(f"--publish is for the reported set, seed {self.seed}")
        return options

    def _run(self, options: argparse.Namespace) -> None:
        from estexp_jax.runs.fleet import do
        from estexp_jax.runs.lock import hold
        from estexp_jax.runs.workers import crew_of

        if options.out.is_dir() and any(options.out.iterdir()) and not options.resume:
            right = "--resume goes on with them, --out puts others elsewhere"
            raise InputError("holds results", where=str(options.out), right=right)
        options.out.mkdir(parents=True, exist_ok=True)
        known = self.entries(options.out, options.seed)
        todo = {case: plan for case, plan in self.numbered(options.seed, options.part).items() if case not in known}
        some = list(todo.items())[: options.most]
        calls = [(self.explained, (options.out, case, plan, options.timeout)) for case, plan in some]
        with hold(options.out), crew_of(options.workers, options.ray, [str(ROOT)]) as crew:
            do("cases", calls, crew, options.out / "under_way")

    def _score(self, options: argparse.Namespace) -> None:
        wanted = self.numbered(options.seed, options.part)
        entries = [e for case, e in self.entries(options.out, options.seed).items() if case in wanted]
        options.out.mkdir(parents=True, exist_ok=True)
        print(f"scores: {self.write_scores(options.out, entries, len(wanted))}")


def row_of(entry: Mapping[str, Any]) -> Row:
    """A row as it was before it became JSON."""
    sizes = tuple(Size(**size) for size in entry["sizes"])
    known = {name: value for name, value in entry.items() if name in Row.__dataclass_fields__}
    return Row(**{**known, "sizes": sizes, "claimed": tuple(entry["claimed"])})


def commit() -> str | None:
    """The commit that is at work here; None where nobody can tell."""
    asked = ["git", "-C", str(Path(__file__).parent), "rev-parse", "HEAD"]
    done = subprocess.run(asked, capture_output=True, text=True, check=False)
    return done.stdout.strip() or None
