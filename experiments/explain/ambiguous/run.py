"""`estexp experiment ambiguous`: what a first motion leaves open, and what one proposed recording settles.

estexp experiment ambiguous --quick                 two ambiguities, one seed
estexp experiment ambiguous --workers 2             eight ambiguities, ten seeds: an hour and more on one core
python experiments/explain/ambiguous/run.py --report        tables and figure of what is finished
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from experiments.harness.options import Options

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

FIRST = 5100
"""First seed of reported cases; ambiguities were put together on seeds below 5100."""
_QUICK = (0, 5)
"""Ambiguities of the quick run."""


def main(arguments: Sequence[str] | None = None) -> int:
    """All cases, then the table and the figure of those that are there; published ones no machine does again."""
    from experiments.explain.ambiguous.ambiguities import AMBIGUITIES
    from experiments.explain.ambiguous.task import settled
    from experiments.harness.options import options_of, options_parser
    from experiments.harness.recovery_runs import each_kept, kept
    from experiments.harness.rows import read_rows
    from experiments.harness.study import Study

    study = Study.of(__file__, __doc__)
    parser = options_parser(study, seeds=10, sizes=False)
    options = options_of(study, arguments, seeds=10, quick_seeds=1, parser=parser)
    published = [] if options.quick else read_rows(Path(__file__).with_name("rows.parquet"))
    rows = {(row["ambiguity"], row["seed"]): row for row in published}
    chosen = _QUICK if options.quick else range(len(AMBIGUITIES))
    cases = [(i, seed) for seed in range(FIRST, FIRST + options.n) for i in chosen]
    files = {case: options.store.parent / "ambiguous_cases" / "{}-{}.json".format(*case) for case in cases}
    if not options.report:
        missing = [case for case in cases if (AMBIGUITIES[case[0]].name, case[1]) not in rows]
        each_kept("cases", {files[c]: (settled, *c, files[c].with_suffix("")) for c in missing}, options)
    finished = [_row(found) for found in map(kept, files.values()) if found is not None]
    rows |= {(row["ambiguity"], row["seed"]): row for row in finished}
    report(list(rows.values()), options)
    study.publish(options.out, options.publish)
    return 0


def _row(found: Mapping[str, Any]) -> dict[str, Any]:
    """A case in a line; of what was not recorded, nothing."""
    row = {name: found[name] for name in ("ambiguity", "seed", "truth")}
    for when in ("before", "random", "proposed"):
        own = found.get(when)
        listed, claims = ("", "") if own is None else (" ".join(own["listed"]), " ".join(own["claims"]))
        row |= {f"{when}_listed": listed, f"{when}_claims": claims}
        row |= {f"{when}_{name}": None if own is None else own[name] for name in ("probability", "alone")}
    return row


def report(rows: Sequence[Mapping[str, Any]], options: Options) -> None:
    """Table, numbers and figure."""
    from experiments.explain.ambiguous.summary import draw, summary
    from experiments.harness.recovery_rows import write_summary
    from experiments.harness.rows import write_rows

    write_rows(options.out / "rows.parquet", rows)
    write_summary(options.out / "summary.json", summary(rows))
    draw(rows, options.out)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
