"""`estexp experiment figure7`: the paper's Figure 7, thirteen situations, and how right the diagnoses are.

estexp experiment figure7 --quick                    one seed, very small runs
estexp experiment figure7 --workers 8                the paper's: 10 seeds, 200 genomes, 40 generations, 1000 steps
python experiments/recover/figure7/run.py --size small --seeds 10
python experiments/recover/figure7/run.py --size small --report     table and figures of the runs finished so far
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from estexp_jax.recovery.config import Metric
    from experiments.harness.options import Options
    from experiments.harness.recovery_case import Method, RecoveryCase, Size

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

ARMS: tuple[tuple[Method, Metric], ...] = (("paper", "distance"), ("paper", "rolling-mean"), ("set", "rolling-mean"))
"""The paper's control, the paper's algorithm, and the set search."""


def main(arguments: Sequence[str] | None = None) -> int:
    """All runs, then the table and the figures."""
    from experiments.harness.options import options_of
    from experiments.harness.recovery_runs import finished, run_cases
    from experiments.harness.study import Study

    study = Study.of(__file__, __doc__)
    options = options_of(study, arguments, seeds=10, quick_seeds=1)
    cases = cases_of(options.size, options.n)
    if not options.report:
        run_cases(cases, options)
    done = [case for case in cases if finished(case, options.store)]
    whole = [arm for arm in ARMS if {c.situation for c in done if (c.method, c.metric) == arm} == set(range(1, 14))]
    report([case for case in done if (case.method, case.metric) in whole], options)
    study.publish(options.out, options.publish)
    return 0


def cases_of(size: Size, n: int) -> list[RecoveryCase]:
    """Seed by seed, so that a run that is stopped leaves whole seeds."""
    from experiments.harness.recovery_case import RecoveryCase, seeds

    return [
        RecoveryCase(situation, seed, size, method, metric)
        for seed in seeds(n)
        for situation in range(1, 14)
        for method, metric in ARMS
    ]


def report(cases: Sequence[RecoveryCase], options: Options) -> None:
    """Tables, numbers and figures of the runs that are finished."""
    from experiments.harness.recovery_rows import row, write_summary
    from experiments.harness.rows import write_rows
    from experiments.recover.figure7.figure import draw_confusion, draw_distances
    from experiments.recover.figure7.summary import confusion, diagnoses, distances, environment

    rows = [row(case, options.store) for case in cases]
    write_rows(options.out / "rows.parquet", rows)
    found = {"distances": distances(rows), "environment": environment(rows)}
    found |= {"diagnoses": diagnoses(rows), "confusion": confusion(rows)}
    seeds = sorted({case.seed for case in cases})
    write_summary(options.out / "summary.json", found, seeds=seeds, size=options.size)
    draw_distances(rows, options.out)
    draw_confusion(found["confusion"], options.out)


if __name__ == "__main__":
    from experiments.harness.study import exit_code

    sys.exit(exit_code(main))
