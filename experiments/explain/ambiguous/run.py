"""`estexp experiment ambiguous`: what a first motion leaves open, and what one proposed recording settles.

estexp experiment ambiguous --quick                 two doubts, one seed
estexp experiment ambiguous --workers 2             eight doubts, ten seeds: an hour and more on one core
python experiments/explain/ambiguous/run.py --report        tables and figure of what is finished
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

FIRST = 5100
"""First seed of reported cases; doubts were put together on seeds below 5100."""
_QUICK = (0, 5)
"""Doubts of the quick run."""


def main(arguments: Sequence[str] | None = None) -> int:
    """All cases, then the table and the figure of those that are there; published ones no machine does again."""
    from experiments.explain.ambiguous.ambiguities import DOUBTS
    from experiments.harness.options import parsed, publish
    from experiments.harness.runs import each
    from experiments.harness.tables import read_rows

    parser = argparse.ArgumentParser(add_help=False)
    parser.add_argument("--report", action="store_true")
    own, rest = parser.parse_known_args(sys.argv[1:] if arguments is None else list(arguments))
    options = parsed("ambiguous", __doc__, seeds=10, quick_seeds=1, arguments=rest)
    quick = options.size == "quick"
    known = [] if quick else read_rows(Path(__file__).with_name("cases.csv"))
    done = {(row["doubt"], row["seed"]) for row in known}
    chosen = _QUICK if quick else range(len(DOUBTS))
    cases = [(i, seed) for seed in range(FIRST, FIRST + options.n) for i in chosen]
    store = options.store.parent / "ambiguous_cases"
    todo = [c for c in cases if not (_file(c, store).is_file() or (DOUBTS[c[0]].name, c[1]) in done)]
    if not own.report:
        each("cases", [(_kept, case, store) for case in todo], options)
    finished = [json.loads(_file(c, store).read_text("utf-8")) for c in cases if _file(c, store).is_file()]
    rows = {(row["doubt"], row["seed"]): row for row in [*known, *map(_row, finished)]}
    report(list(rows.values()), options)
    publish(options, __file__)
    return 0


def _file(case: tuple[int, int], store: Path) -> Path:
    return store / f"{case[0]}-{case[1]}.json"


def _kept(case: tuple[int, int], store: Path) -> None:
    from estexp_jax.runs import write_json
    from experiments.explain.ambiguous.task import settled

    write_json(_file(case, store), settled(*case, _file(case, store).with_suffix("")))


def _row(found: dict[str, Any]) -> dict[str, Any]:
    """A case in a line; of what was not recorded, nothing."""
    row = {name: found[name] for name in ("doubt", "seed", "truth")}
    for when in ("before", "random", "proposed"):
        told = found.get(when)
        listed, claims = ("", "") if told is None else (" ".join(told["listed"]), " ".join(told["claims"]))
        row |= {f"{when}_listed": listed, f"{when}_claims": claims}
        row |= {f"{when}_{name}": None if told is None else told[name] for name in ("probability", "alone")}
    return row


def report(rows: Sequence[dict[str, Any]], options) -> None:
    """Table, numbers and figure."""
    from experiments.explain.ambiguous.summary import draw, summary
    from experiments.harness.tables import write_rows, write_summary

    write_rows(options.out / "cases.csv", rows)
    write_summary(options.out / "summary.json", summary(rows))
    draw(rows, options.out)


if __name__ == "__main__":
    from experiments.harness.options import exit_code

    sys.exit(exit_code(main))
