"""`estexp experiment arguments`: every argument of every command at its ends, beyond, empty, huge and of another kind.

estexp experiment arguments --quick                                     every twentieth
python experiments/robustness/arguments/run.py --only record recover --publish
"""

from __future__ import annotations

import json
import multiprocessing
import sys
import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any
from unittest.mock import patch

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

MOST_S = 5.0
"""Of processor time, that a command line may take to be refused, or until the long work would begin."""


def main(arguments: Sequence[str] | None = None) -> int:
    """All commands, one after another."""
    from experiments.harness.study import Study, words
    from experiments.robustness.arguments.draw import BASE

    study = Study.of(__file__, __doc__)
    parser = study.parser(quick="every twentieth command line")
    parser.add_argument("--only", nargs="+", choices=BASE, default=list(BASE), help="commands")
    given = parser.parse_args(words(arguments))
    out = study.results(given.out)
    summary = out / "summary.json"
    rows = json.loads(summary.read_text()) if summary.exists() else {}
    prepare = multiprocessing.get_context("spawn").Process(target=_prepare, args=(out / "good",))
    prepare.start()
    prepare.join()
    for command in given.only:
        rows[command] = tried(command, out / "good", 20 if given.quick else 1)
        print(f"{command}: " + ", ".join(f"{k} {v}" for k, v in rows[command].items()), flush=True)
        summary.write_text(json.dumps(rows, indent=1) + "\n")
    study.publish(out, given.publish)
    return int(any(row["defects"] for row in rows.values()))


def _prepare(good: Path) -> None:
    from experiments.robustness.fuzz.run import good_results

    good_results(good)


def tried(command: str, good: Path, every: int) -> dict[str, Any]:
    """What came of a command's lines: counts, the longest time, and all that were neither done nor refused."""
    with patch("estexp_jax.api.recover._job_of_options", _stop):  # it compiles first of all
        return _tried(command, good, every)


def _stop(*_: Any) -> Any:
    from experiments.robustness.fuzz.trial import Accepted

    raise Accepted


def _tried(command: str, good: Path, every: int) -> dict[str, Any]:
    from experiments.robustness.arguments.draw import BASE, lines_of
    from experiments.robustness.fuzz.trial import run

    run([command, *BASE[command], "--out", str(good / "tried"), "--force"], good, short=True)  # imports what all need
    counts, defects, longest = {0: 0, 2: 0}, [], 0.0
    for line in list(lines_of(command, good / "tried"))[::every]:
        begin = time.process_time()
        code, message = run([*line, "--force"], good, short=True)
        took = time.process_time() - begin
        longest = max(longest, took)
        if code not in counts or "Traceback" in message or took > MOST_S or (code and not message.strip()):
            defects.append({"line": [text[:60] for text in line], "code": code, "message": message[-400:], "s": took})
            print(f"  {line}: {code}, {took:.1f} s, {message[-400:]}", flush=True)
        else:
            counts[code] += 1
    return {"accepted": counts[0], "refused": counts[2], "longest_s": round(longest, 2), "defects": defects}


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
