"""`estexp experiment trust`: everything in robustness, one after another, as one table of counts; before each release.

estexp experiment trust --quick                                        a little of each: shows that all of it works
estexp experiment trust                                                hours
python experiments/robustness/trust/run.py --only signals fuzz         some of them
python experiments/robustness/trust/run.py --table --publish           only the table of what they have published
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

HERE = Path(__file__).resolve().parent


class Row(NamedTuple):
    """A line of the table.

    Attributes:
        what: was tried.
        tried: how many.
        failed: how many of them ended otherwise than promised.
        longest_s: the longest, s; None: it was not timed.
    """

    what: str
    tried: int
    failed: int
    longest_s: float | None = None


def main(arguments: Sequence[str] | None = None) -> int:
    """The studies, and the table."""
    from experiments.harness.study import Study, words

    study = Study.of(__file__, __doc__)
    parser = study.parser(quick="a little of each")
    parser.add_argument("--only", nargs="+", choices=STUDIES, default=list(STUDIES), help="studies")
    parser.add_argument("--table", action="store_true", help="run nothing")
    given = parser.parse_args(words(arguments))
    out = study.results(given.out)
    failed = [] if given.table else [name for name in given.only if _run(name, out / name, quick=given.quick)]
    text, defects = table(HERE.parent if given.table else out)
    (out / "counts.md").write_text(text, encoding="utf-8")
    print(text)
    study.publish(out, given.publish)
    return int(bool(failed) or defects > 0)


def _run(name: str, out: Path, *, quick: bool) -> int:
    command = [sys.executable, str(HERE.parent / name / "run.py"), "--out", str(out), *(["--quick"] if quick else [])]
    return subprocess.run(command, check=False).returncode


def table(folder: Path) -> tuple[str, int]:
    """The table of all studies whose summary lies in a folder of their name, and how much was not as promised."""
    lines = ["| what was tried | how often | otherwise than promised | longest, s |", "|---|---|---|---|"]
    failed = 0
    for name, rows_of in STUDIES.items():
        summary = folder / name / "summary.json"
        if not summary.is_file():
            lines.append(f"| {name} | not yet | | |")
            continue
        for row in rows_of(json.loads(summary.read_text(encoding="utf-8"))):
            longest = "" if row.longest_s is None else f"{row.longest_s:.3g}"
            lines.append(f"| {row.what} | {row.tried} | {row.failed} | {longest} |")
            failed += row.failed
    return "\n".join(lines) + "\n", failed


def _fuzz(found: Mapping[str, Any]) -> Iterator[Row]:
    for kind, row in found.items():
        yield Row(f"bad input: {kind}", row["tried"], row["crashes"], row["longest_s"])


def _arguments(found: Mapping[str, Any]) -> Iterator[Row]:
    for command, row in found.items():
        tried = row["accepted"] + row["refused"] + len(row["defects"])
        yield Row(f"arguments of `{command}`", tried, len(row["defects"]), row["longest_s"])


def _signals(found: Mapping[str, Any]) -> Iterator[Row]:
    for name, row in found["signals"].items():
        yield Row(f"signals: {name}", row["sent"], row["wrong"], row["longest_s"])
        if row["gone_on"]:
            yield Row(f"gone on after them: {name}", row["gone_on"], row["not_resumed"])


def _kills(found: Mapping[str, Any]) -> Iterator[Row]:
    for command, row in found["commands"].items():
        failed = row["differ"] + row["half_files"] + row["failed"]
        yield Row(f"kills of `{command}`, gone on with", row["kills"], failed)


def _wrong_logs(found: Mapping[str, Any]) -> Iterator[Row]:
    longest = found["check_s"]["largest"]
    yield Row(
        "logs wrong in meaning: not named by their kind", found["wrong"], found["wrong"] - found["named"], longest
    )
    yield Row("right logs: warned of", found["right"], found["warned"])


def _models(of: str) -> Callable[[Mapping[str, Any]], Iterator[Row]]:
    def rows(found: Mapping[str, Any]) -> Iterator[Row]:
        bad = sum(found["results"].get(name, 0) for name in ("wrong", "crashed"))
        yield Row(of, found["models"], bad)

    return rows


STUDIES: dict[str, Callable[[Mapping[str, Any]], Iterator[Row]]] = {
    "fuzz": _fuzz,
    "arguments": _arguments,
    "signals": _signals,
    "crash_recovery": _kills,
    "wrong_logs": _wrong_logs,
    "public_models": _models("models of public packages against plain MuJoCo"),
    "random_models": _models("models drawn at random against plain MuJoCo"),
}
"""The studies of robustness, and the rows of the table that each one's `summary.json` gives."""


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
