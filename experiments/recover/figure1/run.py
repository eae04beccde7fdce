"""`estexp experiment figure1`: the paper's Figure 1, evolving on the damaged robot itself against the full algorithm.

estexp experiment figure1 --quick
estexp experiment figure1 --workers 8
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))


def main(arguments: Sequence[str] | None = None) -> int:
    """Both ways for every seed, table and figure."""
    from experiments.harness.options import options_of
    from experiments.harness.recovery_case import RecoveryCase, seeds
    from experiments.harness.recovery_rows import write_summary
    from experiments.harness.recovery_runs import each, run_cases
    from experiments.harness.rows import write_rows
    from experiments.harness.study import Study
    from experiments.recover.figure1.direct import compared, courses, direct
    from experiments.recover.figure1.figure import draw

    study = Study.of(__file__, __doc__)
    options = options_of(study, arguments, seeds=10, quick_seeds=2)
    legs = ("f", "l", "b", "r")
    damaged = [(seed, (f"part_lost@lower_{legs[seed % 4]}",)) for seed in seeds(options.n)]
    cases = [
        RecoveryCase(None, seed, options.size, method, damage=damage)
        for seed, damage in damaged
        for method in ("set", "paper")
    ]
    run_cases(cases, options)
    runs = each("on the robot", [(direct, case, options.store) for case in cases[::2]], options)
    rows = compared(cases, runs, options.store)
    write_rows(options.out / "rows.parquet", rows)
    found = draw(runs, courses(cases, options.store), rows, options.out)
    write_summary(options.out / "summary.json", found, seeds=options.n, size=options.size)
    study.publish(options.out, options.publish)
    return 0


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
