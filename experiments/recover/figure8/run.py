"""`estexp experiment figure8`: the paper's Figure 8, new best hypotheses in each estimation, and random search.

estexp experiment figure8 --quick
estexp experiment figure8 --workers 8            on the runs of figure7, made where they are missing
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """The paper's runs, random search on their first trials, table and figure."""
    from experiments.harness.options import options_of
    from experiments.harness.recovery_rows import write_summary
    from experiments.harness.recovery_runs import each, run_cases
    from experiments.harness.rows import write_rows
    from experiments.harness.study import Study
    from experiments.recover.figure7.run import cases_of
    from experiments.recover.figure8.count import Count, counted, random_search
    from experiments.recover.figure8.figure import draw

    study = Study.of(__file__, __doc__)
    options = options_of(study, arguments, seeds=10, quick_seeds=1)
    cases = [case for case in cases_of(options.size, options.n) if case.method == "paper"]
    run_cases(cases, options)
    evolved: list[Count] = [count for case in cases for count in counted(case, options.store)]
    drawn = each("random searches", [(random_search, case, options.store) for case in cases], options)
    counts = [*evolved, *drawn]
    write_rows(options.out / "rows.parquet", [count._asdict() for count in counts])
    write_summary(options.out / "summary.json", draw(counts, options.out), seeds=options.n, size=options.size)
    study.publish(options.out, options.publish)
    return 0


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
